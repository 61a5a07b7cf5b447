/* A row of the tables of refused calls: a function, and the one thing that is wrong with what it is given. */
#ifndef ROW_H
#define ROW_H

#include <math.h>

#include "given.h"

/* A function under test: its good arguments, the call, and what undoes a call that succeeds. */
typedef struct Function {
    const char *name;
    void (*good)(Given *);
    DrrStatus (*call)(const Given *);
    void (*undo)(const Given *);
} Function;

/* One value of what is given, replaced. */
typedef struct Change {
    size_t offset, size, room;
    const void *value;
} Change;

#define CHANGE(member, type, value) {offsetof(Given, member), sizeof(type), sizeof(((Given *)0)->member), value}
#define PUT(member, type, ...) CHANGE(member, type, (&(type){__VA_ARGS__}))
#define POINT(member, pointer) CHANGE(member, void *, (&(void *){pointer}))
/* Points one byte past the pointee, where nothing but bytes is aligned. */
#define ASKEW(member, pointee) POINT(member, (char *)&given.to.pointee + 1)
#define NOTHING {0, 0, 0, NULL}

typedef struct Row {
    /* NULL: those that the rows are run for. */
    const Function *function;
    /* The parameter, or the field of what it points to. */
    const char *argument;
    const char *kind;
    /* What else differs from the good arguments; accepted on its own when there is a change. */
    void (*setting)(Given *);
    Change change;
    DrrStatus status;
    /* The message says "argument is value", and what is valid. */
    const char *value, *valid;
} Row;

#define INVALID DRR_STATUS_INVALID_ARGUMENT

/* The parameter's or field's own name. */
static inline const char *leaf(const char *argument) {
    const char *dot = strrchr(argument, '.');
    return dot == NULL ? argument : dot + 1;
}

/* What a function needs that is made of what it is given, whatever a row's setting is; and what undoes that. */
static void (*make_ready)(Given *);
static void (*clear_away)(void);

static inline void prepare(const Row *row) {
    good(&given);
    if (row->function->good != NULL) row->function->good(&given);
}

/* The good call, before and after bad ones: what a row changes is all that is wrong with it. */
static inline int succeeds(const Row *row) {
    prepare(row);
    if (row->setting != NULL && row->change.size > 0) row->setting(&given);
    if (make_ready != NULL) make_ready(&given);
    OK(row->function->call(&given));
    if (row->function->undo != NULL) row->function->undo(&given);
    if (clear_away != NULL) clear_away();
    return 0;
}

static inline int refused(const Row *row) {
    static Given before;
    prepare(row);
    if (row->setting != NULL) row->setting(&given);
    if (make_ready != NULL) make_ready(&given);
    CHECK(row->change.size == row->change.room);
    if (row->change.size > 0) memcpy((char *)&given + row->change.offset, row->change.value, row->change.size);
    memcpy(&before, &given, sizeof before);
    CHECK(row->function->call(&given) == row->status);
    CHECK(memcmp(&before, &given, sizeof before) == 0);
    if (clear_away != NULL) clear_away();
    const char *message = drr_last_error_message();
    CHECK(strstr(message, row->value) != NULL && strstr(message, row->valid) != NULL);
    CHECK(row->status != INVALID || strstr(message, leaf(row->argument)) != NULL);
    CHECK(row->status != INVALID || (strstr(message, " is ") != NULL && strstr(message, "; valid: ") != NULL));
    return 0;
}

/* Says which rows there are, one a line, for whoever checks that none is missing. */
static inline int run_rows(const Row *rows, size_t count, const Function *function) {
    for (size_t i = 0; i < count; i++) {
        Row row = rows[i];
        if (row.function == NULL) row.function = function;
        printf("%s %s %s\n", row.function->name, row.argument, row.kind);
        if (succeeds(&row) || refused(&row) || succeeds(&row)) return 1;
    }
    return 0;
}

#define RUN(rows) run_rows(rows, sizeof rows / sizeof *rows, NULL)
#define RUN_FOR(function, rows) run_rows(rows, sizeof rows / sizeof *rows, function)

#endif
