// Stand-in, see ../README.md.
#pragma once
typedef __attribute__((__ext_vector_type__(3))) float simd_float3;
typedef __attribute__((__ext_vector_type__(4))) float simd_float4;
typedef struct {
    simd_float4 columns[4];
} simd_float4x4;
