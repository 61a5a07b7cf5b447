// What the demo's kernels compute is what DRRPicture writes, and medians.
#import <Foundation/Foundation.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#import "DRRMemory.h"
#import "DRRPicture.h"

void show(const float *intensity, float window, float level, unsigned views, unsigned size, float *greys);
void denoise(const float *from, float *to, unsigned views, unsigned size);

enum { VIEWS = 2, SIZE = 21, COUNT = VIEWS * SIZE * SIZE };

static int by_value(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// The largest difference in levels of 16 bits.
static double shown_otherwise(const float *intensity) {
    static float greys[COUNT];
    DRRPicture *const picture =
        [[[DRRPicture alloc] initWithIntensity:intensity views:VIEWS width:SIZE height:SIZE] autorelease];
    const unsigned char *const written = [[picture pixels] bytes];
    show(intensity, (float)picture.window, (float)picture.level, VIEWS, SIZE, greys);
    double largest = 0;
    for (int n = 0; n < COUNT; n++)
        largest = fmax(largest, fabs(65535.0 * (double)greys[n] - (256 * written[2 * n] + written[2 * n + 1])));
    return largest;
}

static int wrong_medians(const float *from) {
    static float to[COUNT];
    int wrong = 0;
    denoise(from, to, VIEWS, SIZE);
    for (int n = 0; n < COUNT; n++) {
        const int i = n % SIZE, j = n / SIZE % SIZE;
        float around[9];
        const int edge = i == 0 || j == 0 || i == SIZE - 1 || j == SIZE - 1;
        for (int m = 0; m < 9; m++) around[m] = edge ? from[n] : from[n + (m / 3 - 1) * SIZE + m % 3 - 1];
        qsort(around, 9, sizeof *around, by_value);
        wrong += to[n] != around[4];
    }
    return wrong;
}

int main(void) {
    static float intensity[COUNT];
    unsigned state = 1;
    for (int n = 0; n < COUNT; n++) {
        state = 1664525 * state + 1013904223;
        intensity[n] = expf(-8.0f * (float)(state >> 8) / 16777216.0f);
    }
    intensity[100] = 0.0f; /* what noise leaves */
    intensity[200] = -0.1f;
    int failed = 0;
    DRR_POOL {
        const double otherwise = shown_otherwise(intensity);
        const int wrong = wrong_medians(intensity);
        failed = !(otherwise <= 2) || wrong != 0;
        printf("%s: %g levels, %d wrong medians\n", failed ? "FAIL" : "PASS", otherwise, wrong);
    }
    return failed;
}
