/* A stand-in for NVIDIA's run-time compiler: the kernel's text for CUDA, compiled for the host by its C++ compiler. The
 * "cubin" is the path of a shared library, which driver.c loads. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SUCCESS = 0, OUT_OF_MEMORY = 1, INVALID_OPTION = 5, COMPILATION = 6 };

typedef struct {
    char *source, *log;
    char path[64];
} Program;

/* What NVRTC knows without being told, for one thread of the host; and the entry points by their parameters' addresses. */
static const char before[] = "#define __global__\n"
                             "#define __launch_bounds__(...)\n"
                             "#define __grid_constant__\n"
                             "struct StandInPlace { unsigned x, y, z; };\n"
                             "static thread_local StandInPlace blockIdx, threadIdx, blockDim;\n";
static const char after[] =
    "\nstatic void stand_in_place(const unsigned *p) {\n"
    "    blockDim = {p[0], p[1], 1}; blockIdx = {p[2], p[3], 0}; threadIdx = {p[4], p[5], 0};\n"
    "}\n"
    "#if defined(DRR_PARALLEL_H)\n"
    "extern \"C\" void stand_in_projectParallel(const unsigned *p, void **a) {\n"
    "    stand_in_place(p);\n"
    "    projectParallel(*(const DrrParallelLaunch *)a[0], *(const DrrParallelView **)a[1], *(DrrParallelRays *)a[2],\n"
    "                    *(float **)a[3]);\n"
    "}\n"
    "extern \"C\" void stand_in_sumParallel(const unsigned *p, void **a) {\n"
    "    stand_in_place(p);\n"
    "    sumParallel(*(const DrrParallelLaunch *)a[0], *(const float **)a[1], *(float **)a[2]);\n"
    "}\n"
    "#else\n"
    "extern \"C\" void stand_in_projectPolyenergeticDRR(const unsigned *p, void **a) {\n"
    "    stand_in_place(p);\n"
    "    projectPolyenergeticDRR(*(const DrrLaunch *)a[0], *(const DrrBeam **)a[1], *(DrrVoxels *)a[2],\n"
    "                            *(DrrSpectra *)a[3], *(DrrImages *)a[4]\n"
    "#if defined(DRR_SIGNALS)\n"
    "                            , *(const DrrChannels *)a[5], *(DrrPoseSignals *)a[6]\n"
    "#endif\n"
    "    );\n"
    "}\n"
    "#endif\n";

int nvrtcVersion(int *major, int *minor) {
    *major = 13;
    *minor = 0;
    return SUCCESS;
}

int nvrtcGetNumSupportedArchs(int *count) {
    *count = 2;
    return SUCCESS;
}

int nvrtcGetSupportedArchs(int *architectures) {
    architectures[0] = 75;
    architectures[1] = 90;
    return SUCCESS;
}

int nvrtcCreateProgram(void **place, const char *source, const char *name, int count, const char *const *headers,
                       const char *const *names) {
    (void)name, (void)count, (void)headers, (void)names;
    Program *program = (Program *)calloc(1, sizeof *program);
    if (program == NULL) return OUT_OF_MEMORY;
    program->source = strdup(source);
    *place = program;
    return SUCCESS;
}

int nvrtcDestroyProgram(void **place) {
    Program *program = (Program *)*place;
    free(program->source);
    free(program->log);
    free(program);
    *place = NULL;
    return SUCCESS;
}

/* Runs the compiler on what its standard input is given; what it says becomes the program's log. */
static int run(Program *program, const char *options) {
    char command[4096], log[sizeof program->path + 4];
    snprintf(log, sizeof log, "%s.log", program->path);
    snprintf(command, sizeof command,
             "c++ -x c++ -std=c++17 -O1 -march=native -ffp-contract=off -w -shared -fPIC %s -o %s - 2>%s", options,
             program->path, log);
    FILE *input = popen(command, "w");
    if (input == NULL) return COMPILATION;
    fputs(before, input);
    fputs(program->source, input);
    fputs(after, input);
    const int status = pclose(input) == 0 ? SUCCESS : COMPILATION;
    program->log = (char *)calloc(1, 1 << 16);
    FILE *said = fopen(log, "r");
    if (said != NULL) {
        const size_t length = fread(program->log, 1, (1 << 16) - 1, said);
        program->log[length] = '\0';
        fclose(said);
        unlink(log);
    }
    return status;
}

/* Options of the preprocessor are the C++ compiler's too; the others must be those that keep the arithmetic as written. */
int nvrtcCompileProgram(void *place, int count, const char *const *options) {
    static const char *const known[] = {"--std=c++17",     "--fmad=false",     "--ftz=false",
                                        "--prec-div=true", "--prec-sqrt=true", "--gpu-architecture=sm_90"};
    Program *program = (Program *)place;
    char definitions[2048] = "";
    for (int n = 0; n < count; n++) {
        int is_known = strncmp(options[n], "-D", 2) == 0;
        if (is_known) strcat(strcat(definitions, " "), options[n]);
        for (size_t k = 0; k < sizeof known / sizeof *known; k++) is_known |= strcmp(options[n], known[k]) == 0;
        if (!is_known) return INVALID_OPTION;
    }
    strcpy(program->path, "/tmp/drr-stand-in-XXXXXX");
    const int file = mkstemp(program->path);
    if (file < 0) return COMPILATION;
    close(file);
    return run(program, definitions);
}

int nvrtcGetProgramLogSize(void *program, size_t *size) {
    const char *log = ((Program *)program)->log;
    *size = log == NULL ? 1 : strlen(log) + 1;
    return SUCCESS;
}

int nvrtcGetProgramLog(void *program, char *place) {
    const char *log = ((Program *)program)->log;
    strcpy(place, log == NULL ? "" : log);
    return SUCCESS;
}

int nvrtcGetCUBINSize(void *program, size_t *size) {
    *size = strlen(((Program *)program)->path) + 1;
    return SUCCESS;
}

int nvrtcGetCUBIN(void *program, char *place) {
    strcpy(place, ((Program *)program)->path);
    return SUCCESS;
}
