/* Wrong on purpose: the voxels are written while a volume is made of them. Shows that the sanitizer sees what the
 * program and the library's own threads do. */
#include <pthread.h>
#include <string.h>

#include "water.h"

static int16_t hu[N * N * N];

static void *spoil(void *unused) {
    for (int i = 0; i < N * N * N; i++) hu[i] = 1;
    return unused;
}

int main(void) {
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    const DrrVolumeDescriptor descriptor = water_descriptor();
    pthread_t thread;
    OK(drr_context_create(NULL, &context));
    memcpy(hu, water_ball(), sizeof hu);
    CHECK(pthread_create(&thread, NULL, spoil, NULL) == 0);
    OK(drr_volume_create(context, &descriptor, hu, NULL, &volume));
    CHECK(pthread_join(thread, NULL) == 0);
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    return 0;
}
