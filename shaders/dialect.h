// What the three compilers call the same things. The only file that asks which of them is reading: Metal's (or its
// stand-in), NVIDIA's run-time compiler, or a C++17 compiler for the host.
//
// Every function below these lines is written once, and computes the same bits everywhere: products and sums are not
// contracted, so what is fused is written fused.
#ifndef DRR_DIALECT_H
#define DRR_DIALECT_H

#if defined(__METAL_VERSION__)

#include <metal_stdlib>
using namespace metal;
#pragma METAL fp math_mode(safe)
#pragma METAL fp contract(off)
#define DRR_DEVICE device
#define DRR_CONSTANT constant
#define DRR_THREAD thread
#define DRR_RESTRICT
#define DRR_UNROLL _Pragma("unroll")
#define DRR_UNROLL_FOUR _Pragma("unroll 4")
#define DRR_FUNCTION static inline
#define DRR_METHOD inline
typedef long DrrLong;
typedef ulong DrrUlong;
DRR_FUNCTION float drr_fma(float a, float b, float c) { return metal::fma(a, b, c); }
DRR_FUNCTION float drr_abs(float x) { return metal::fabs(x); }
DRR_FUNCTION float drr_min(float a, float b) { return metal::fmin(a, b); }
DRR_FUNCTION float drr_max(float a, float b) { return metal::fmax(a, b); }
DRR_FUNCTION float drr_floor(float x) { return metal::floor(x); }
DRR_FUNCTION float drr_rint(float x) { return metal::rint(x); }
DRR_FUNCTION float drr_sqrt(float x) { return metal::precise::sqrt(x); }
DRR_FUNCTION float drr_log(float x) { return metal::precise::log(x); }
DRR_FUNCTION float drr_float_of_bits(uint bits) { return as_type<float>(bits); }
DRR_FUNCTION uint drr_bits_of_float(float x) { return as_type<uint>(x); }
// Whether any thread that runs beside this one says so. Decides what is faster, never what is computed.
DRR_FUNCTION bool drr_any(bool here) { return metal::simd_any(here); }
// Reads what no thread writes.
template <typename T>
DRR_FUNCTION T drr_load(const device T *place) { return *place; }
// Four floats at a place that is aligned to 16 bytes.
DRR_FUNCTION void drr_load_four(const device float *place, thread float *four) {
    const float4 all = *(const device float4 *)place;
    four[0] = all.x;
    four[1] = all.y;
    four[2] = all.z;
    four[3] = all.w;
}
// 2^-23 code + origin, rounded once, for a code below 2^16.
DRR_FUNCTION float drr_number_of_code(uint code, float origin) {
    return metal::fma((float)code, 0x1p-23f, origin);
}

#elif defined(__CUDACC__) || defined(__CUDACC_RTC__)

typedef unsigned int uint;
typedef unsigned short ushort;
typedef unsigned char uchar;
typedef long long DrrLong;
typedef unsigned long long DrrUlong;
#define DRR_DEVICE
#define DRR_CONSTANT const
#define DRR_THREAD
#define DRR_RESTRICT __restrict__
#define DRR_UNROLL _Pragma("unroll")
#define DRR_UNROLL_FOUR _Pragma("unroll 4")
#define DRR_FUNCTION static __device__ __forceinline__
#define DRR_METHOD __device__ __forceinline__
DRR_FUNCTION float drr_fma(float a, float b, float c) { return __fmaf_rn(a, b, c); }
DRR_FUNCTION float drr_abs(float x) { return fabsf(x); }
DRR_FUNCTION float drr_min(float a, float b) { return fminf(a, b); }
DRR_FUNCTION float drr_max(float a, float b) { return fmaxf(a, b); }
DRR_FUNCTION float drr_floor(float x) { return floorf(x); }
DRR_FUNCTION float drr_rint(float x) { return rintf(x); }
DRR_FUNCTION float drr_sqrt(float x) { return __fsqrt_rn(x); }
DRR_FUNCTION float drr_log(float x) { return logf(x); }
DRR_FUNCTION float drr_float_of_bits(uint bits) { return __uint_as_float(bits); }
DRR_FUNCTION uint drr_bits_of_float(float x) { return __float_as_uint(x); }
DRR_FUNCTION bool drr_any(bool here) { return __any_sync(__activemask(), here); }
template <typename T>
DRR_FUNCTION T drr_load(const T *place) { return __ldg(place); }
DRR_FUNCTION void drr_load_four(const float *place, float *four) {
    const float4 all = __ldg((const float4 *)place);
    four[0] = all.x;
    four[1] = all.y;
    four[2] = all.z;
    four[3] = all.w;
}
// As a denormal number a code is 2^-149 code: no conversion, which would take another unit's time.
DRR_FUNCTION float drr_number_of_code(uint code, float origin) {
    return __fmaf_rn(__uint_as_float(code), 0x1p126f, origin);
}

#else

#include <cmath>
#include <cstdint>
#include <cstring>
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif
typedef unsigned int uint;
typedef unsigned short ushort;
typedef unsigned char uchar;
typedef std::int64_t DrrLong;
typedef std::uint64_t DrrUlong;
#define DRR_DEVICE
#define DRR_CONSTANT const
#define DRR_THREAD
#define DRR_RESTRICT __restrict__
#define DRR_UNROLL
#define DRR_UNROLL_FOUR
#define DRR_FUNCTION static inline
#define DRR_METHOD inline
DRR_FUNCTION float drr_fma(float a, float b, float c) { return std::fma(a, b, c); }
DRR_FUNCTION float drr_abs(float x) { return std::fabs(x); }
DRR_FUNCTION float drr_min(float a, float b) { return std::fmin(a, b); }
DRR_FUNCTION float drr_max(float a, float b) { return std::fmax(a, b); }
DRR_FUNCTION float drr_floor(float x) { return std::floor(x); }
DRR_FUNCTION float drr_rint(float x) { return std::nearbyint(x); }
DRR_FUNCTION float drr_sqrt(float x) { return std::sqrt(x); }
DRR_FUNCTION float drr_log(float x) { return std::log(x); }
DRR_FUNCTION float drr_float_of_bits(uint bits) { float x; std::memcpy(&x, &bits, sizeof x); return x; }
DRR_FUNCTION uint drr_bits_of_float(float x) { uint bits; std::memcpy(&bits, &x, sizeof bits); return bits; }
DRR_FUNCTION bool drr_any(bool here) { return here; }
template <typename T>
DRR_FUNCTION T drr_load(const T *place) { return *place; }
DRR_FUNCTION void drr_load_four(const float *place, float *four) { std::memcpy(four, place, 4 * sizeof *four); }
DRR_FUNCTION float drr_number_of_code(uint code, float origin) { return std::fma((float)code, 0x1p-23f, origin); }

#endif

#endif
