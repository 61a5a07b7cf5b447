// Stand-in, see ../README.md.
#pragma once
#define M_PI 3.14159265358979323846
#define NAN __builtin_nanf("")
#define INFINITY __builtin_inff()
#define isnan(x) __builtin_isnan(x)
double ceil(double), cos(double), exp(double), fmax(double, double), fmin(double, double), floor(double), log(double);
double pow(double, double), sin(double), sqrt(double);
float fmaxf(float, float), logf(float);
long lrint(double), lround(double);
