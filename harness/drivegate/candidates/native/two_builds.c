/* Two builds of one controller, stepped side by side. The plain one answers the loop, and the instrumented one, which
 * counts or looks for undefined behaviour, must answer the same. It gets copies of what is sensed, each as long as the
 * contract says, so that a read past an end shows. */
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
    step plain, instrumented;
    void *plain_state, *instrumented_state;
    unsigned char *sense, *currents, *command; /* copies for the instrumented build */
    int64_t sense_size, command_size;          /* bytes */
    int64_t currents_offset, currents_size;    /* place of the pointer in a Sense; bytes of what it points to */
    int64_t differs;                           /* whether the answers have differed since the reset */
    double time;                               /* when they did; the time follows on the size in every Sense */
    unsigned char answers[2][256];             /* the answers that differ, the plain one first */
} builds;

EXTERN EXPORT void drivegate_step_two_builds(void *state, const void *sense, void *command);

void drivegate_step_two_builds(void *state, const void *sense, void *command) {
    builds *both = (builds *)state;
    unsigned char *sensed = both->sense;
    const void *currents;
    memcpy(sensed, sense, (size_t)both->sense_size);
    memcpy(&currents, sensed + both->currents_offset, sizeof currents);
    memcpy(both->currents, currents, (size_t)both->currents_size);
    memcpy(sensed + both->currents_offset, &both->currents, sizeof both->currents);
    memcpy(both->command, command, (size_t)both->command_size);
    both->plain(both->plain_state, sense, command);
    both->instrumented(both->instrumented_state, sensed, both->command);
    if (memcmp(command, both->command, (size_t)both->command_size) == 0 || both->differs) return;
    both->differs = 1;
    memcpy(&both->time, sensed + sizeof(int64_t), sizeof both->time);
    memcpy(both->answers[0], command, (size_t)both->command_size);
    memcpy(both->answers[1], both->command, (size_t)both->command_size);
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
