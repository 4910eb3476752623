/* Single precision for controller.c: the unit of a Cortex-M4 computes in it, and would need a function of the library for
 * each operation on a double. */
#include <math.h>

#define real float
#define sin sinf
#define cos cosf
#define sqrt sqrtf
#define fabs fabsf
#define fmin fminf
#define fmax fmaxf
