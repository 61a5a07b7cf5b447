// Stand-in, see ../README.md.
#pragma once
#define EX_OK 0
#define EX_USAGE 64
#define EX_NOINPUT 66
#define EX_SOFTWARE 70
#define EX_CANTCREAT 73
