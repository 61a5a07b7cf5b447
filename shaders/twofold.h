// Numbers as unevaluated sums of two float32, for setting rays up and for sums of many terms: 48 bits where GPUs have no
// float64.
// Sums: Knuth, The Art of Computer Programming 2, 4.2.2; products by fused multiply-add; both as in Hida, Li and Bailey,
// Algorithms for quad-double precision floating point arithmetic, ARITH-15 (2001).
#ifndef DRR_TWOFOLD_H
#define DRR_TWOFOLD_H

#include "wire.h"

// high + low, when |low| is not above |high|.
DRR_FUNCTION DrrTwofold drr_renormalised(float high, float low) {
    DrrTwofold sum;
    sum.high = high + low;
    sum.low = low - (sum.high - high);
    return sum;
}

DRR_FUNCTION DrrTwofold drr_sum_of(float a, float b) {
    DrrTwofold sum;
    sum.high = a + b;
    const float of_b = sum.high - a;
    sum.low = (a - (sum.high - of_b)) + (b - of_b);
    return sum;
}

DRR_FUNCTION DrrTwofold drr_twofold(float x) {
    DrrTwofold same;
    same.high = x;
    same.low = 0.0f;
    return same;
}

DRR_FUNCTION DrrTwofold drr_negated(DrrTwofold a) {
    a.high = -a.high;
    a.low = -a.low;
    return a;
}

DRR_FUNCTION DrrTwofold drr_add(DrrTwofold a, DrrTwofold b) {
    const DrrTwofold high = drr_sum_of(a.high, b.high);
    const DrrTwofold low = drr_sum_of(a.low, b.low);
    const DrrTwofold sum = drr_renormalised(high.high, high.low + low.high);
    return drr_renormalised(sum.high, sum.low + low.low);
}

// Adds to a sum of many terms, with what rounding takes from it.
DRR_FUNCTION void drr_add_to(DRR_THREAD DrrTwofold &sum, float term) {
    const DrrTwofold high = drr_sum_of(sum.high, term);
    sum = drr_renormalised(high.high, sum.low + high.low);
}

DRR_FUNCTION DrrTwofold drr_subtract(DrrTwofold a, DrrTwofold b) { return drr_add(a, drr_negated(b)); }

DRR_FUNCTION DrrTwofold drr_multiply(DrrTwofold a, DrrTwofold b) {
    const float high = a.high * b.high;
    const float rest = drr_fma(a.high, b.high, -high);
    return drr_renormalised(high, drr_fma(a.high, b.low, drr_fma(a.low, b.high, rest)));
}

// Exact when the quotient is a float32.
DRR_FUNCTION DrrTwofold drr_divide(DrrTwofold a, DrrTwofold b) {
    const float first = a.high / b.high;
    DrrTwofold rest = drr_subtract(a, drr_multiply(b, drr_twofold(first)));
    const float second = rest.high / b.high;
    rest = drr_subtract(rest, drr_multiply(b, drr_twofold(second)));
    const DrrTwofold quotient = drr_renormalised(first, second);
    return drr_renormalised(quotient.high, quotient.low + rest.high / b.high);
}

DRR_FUNCTION bool drr_less(DrrTwofold a, DrrTwofold b) {
    return a.high < b.high || (a.high == b.high && a.low < b.low);
}

DRR_FUNCTION DrrTwofold drr_larger(DrrTwofold a, DrrTwofold b) {
    if (drr_less(a, b)) return b;
    return a;
}

DRR_FUNCTION DrrTwofold drr_smaller(DrrTwofold a, DrrTwofold b) {
    if (drr_less(b, a)) return b;
    return a;
}

DRR_FUNCTION DrrTwofold drr_magnitude(DrrTwofold a) {
    if (a.high < 0.0f || (a.high == 0.0f && a.low < 0.0f)) return drr_negated(a);
    return a;
}

// The largest whole number that is not above a; |a| < 2^23.
DRR_FUNCTION float drr_floor_of(DrrTwofold a) {
    const float whole = drr_floor(a.high);
    return whole == a.high && a.low < 0.0f ? whole - 1.0f : whole;
}

DRR_FUNCTION float drr_rounded(DrrTwofold a) { return a.high + a.low; }

// a at pixel (column, row).
DRR_FUNCTION DrrTwofold drr_at(DRR_CONSTANT DrrAffine &a, DrrTwofold column, DrrTwofold row) {
    const DrrTwofold across = drr_multiply(a.column, column);
    return drr_add(drr_add(a.offset, across), drr_multiply(a.row, row));
}

#endif
