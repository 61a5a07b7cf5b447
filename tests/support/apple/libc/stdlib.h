// Stand-in, see ../README.md.
#pragma once
#include <stddef.h>
void *malloc(size_t size);
void free(void *memory);
void qsort(void *base, size_t count, size_t width, int (*compare)(const void *, const void *));
int abs(int number);
double strtod(const char *text, char **end);
