// Stand-in, see ../README.md.
#pragma once
#include <stddef.h>
void *memcpy(void *to, const void *from, size_t size);
int memcmp(const void *a, const void *b, size_t size);
