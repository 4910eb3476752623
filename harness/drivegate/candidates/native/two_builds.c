/* Builds of one controller, stepped side by side. The plain one answers the loop. The instrumented one counts or looks
 * for undefined behaviour, and must answer as its reference does: the plain build, or one with the same flags but for
 * the instruments. It gets copies of what is sensed, each as long as the contract says, so that a read past an end
 * shows. */
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
#define EXTERN extern "C"
#else
#define EXTERN extern
#endif
#define EXPORT __attribute__((visibility("default")))

typedef void (*step)(void *state, const void *sense, void *command);

typedef struct {
    step plain, instrumented, reference;       /* no reference where the plain build is it */
    void *plain_state, *instrumented_state, *reference_state;
    unsigned char *sense, *currents, *command; /* copies for the instrumented build */
    int64_t sense_size, command_size;          /* bytes */
    int64_t currents_offset, currents_size;    /* place of the pointer in a Sense; bytes of what it points to */
    int64_t differs;                           /* whether the answers have differed since the reset */
    unsigned char answers[2][256];             /* the last answers of the reference and of the instrumented build */
} builds;

EXTERN EXPORT void drivegate_step_two_builds(void *state, const void *sense, void *command);

/* The controllers' steps have records of their own as arguments, which are any here. */
#ifdef __clang__
__attribute__((no_sanitize("function")))
#endif
void drivegate_step_two_builds(void *state, const void *sense, void *command) {
    builds *both = (builds *)state;
    size_t size = (size_t)both->command_size;
    unsigned char *sensed = both->sense;
    const void *currents;
    memcpy(sensed, sense, (size_t)both->sense_size);
    memcpy(&currents, sensed + both->currents_offset, sizeof currents);
    memcpy(both->currents, currents, (size_t)both->currents_size);
    memcpy(sensed + both->currents_offset, &both->currents, sizeof both->currents);
    memcpy(both->command, command, size);
    memcpy(both->answers[0], command, size);
    /* First, so that what ends the process in any build is reported. */
    both->instrumented(both->instrumented_state, sensed, both->command);
    memcpy(both->answers[1], both->command, size);
    both->plain(both->plain_state, sense, command);
    if (both->reference) both->reference(both->reference_state, sense, both->answers[0]);
    else memcpy(both->answers[0], command, size);
    if (memcmp(both->answers[0], both->answers[1], size) == 0) return;
    both->differs = 1;
    /* A negative size ends the run. */
    int64_t stop = -1;
    memcpy(command, &stop, sizeof stop);
}

#ifdef DRIVEGATE_COUNTS
EXTERN void __gcov_dump(void);
EXTERN void __gcov_reset(void);
EXTERN EXPORT void drivegate_write_counters(void);

void drivegate_write_counters(void) {
    __gcov_dump();
    __gcov_reset();
}
#endif

#ifdef DRIVEGATE_FILL
/* The linker leads the controller's allocations here, so that what is read before it is written differs between two
 * builds. */
#define FILLING(name) \
    EXTERN void *__real_##name(size_t size); \
    EXTERN void *__wrap_##name(size_t size); \
    void *__wrap_##name(size_t size) { \
        void *memory = __real_##name(size); \
        return memory ? memset(memory, DRIVEGATE_FILL, size) : memory; \
    }
FILLING(malloc)
#ifdef __cplusplus
FILLING(_Znwm)
FILLING(_Znam)
#endif
#endif
