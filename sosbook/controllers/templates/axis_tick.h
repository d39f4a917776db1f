/* axis_tick.h: the arithmetic of a tick, for the program that includes it
 *
 * (Where this comes from.)
 */
#ifndef AXIS_TICK_H
#define AXIS_TICK_H

#include <float.h>
#include "axis.h"

#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__)
#error "-ffast-math, or -ffinite-math-only, breaks the checks for what is not a number"
#endif
#if FLT_EVAL_METHOD != 0
#error "sums must round to their type at once: for x86 use -mfpmath=sse"
#endif
#if !AXIS_SINGLE && DBL_MANT_DIG != 53
#error "double has other digits than was proven: take single precision"
#endif
#if AXIS_SINGLE && FLT_MANT_DIG != 24
#error "float has other digits than was proven"
#endif

enum {
    STATES = AXIS_STATES,
    MEASURED = AXIS_MEASURED,
    SET_POINTS = AXIS_SET_POINTS,
    OUTPUTS = AXIS_OUTPUTS
};

/* x+ = A x + B y + BR r + W (v - u), u = C x + D y + DR r, and v is u within
 * its limits: what acts on the machine is what the memory knows of. */
#if AXIS_STATES > 0
static const axis_real A[AXIS_STATES][AXIS_STATES] = AXIS_A;
static const axis_real B[AXIS_STATES][AXIS_MEASURED] = AXIS_B;
static const axis_real BR[AXIS_STATES][AXIS_ROOM(AXIS_SET_POINTS)] = AXIS_BR;
static const axis_real W[AXIS_STATES][AXIS_OUTPUTS] = AXIS_W;
static const axis_real START[AXIS_STATES][AXIS_MEASURED] = AXIS_START;
#endif
static const axis_real C[AXIS_OUTPUTS][AXIS_ROOM(AXIS_STATES)] = AXIS_C;
static const axis_real D[AXIS_OUTPUTS][AXIS_MEASURED] = AXIS_D;
static const axis_real DR[AXIS_OUTPUTS][AXIS_ROOM(AXIS_SET_POINTS)] = AXIS_DR;

/* False for what is not a number. */
static inline int within(axis_real value, axis_real bound)
{
    return value >= -bound && value <= bound;
}

static inline axis_real cut(axis_real value, axis_real bound)
{
    return value > bound ? bound : value < -bound ? -bound : value;
}

/* Whether a reading moved no further than it can in the ticks since the last
 * good one, of which so many are lost; false for what is not a number. */
static inline int believable(axis_real moved, axis_real most, int lost)
{
    return within(moved, most * (axis_real)(lost + 1));
}

/* total + row * values, from the left. */
static inline axis_real added(axis_real total, const axis_real row[],
    const axis_real values[], int count)
{
    for (int i = 0; i < count; i++)
        total = total + row[i] * values[i];
    return total;
}

/* What the law answers at the output k. */
static inline axis_real answered(int k, const axis_real x[],
    const axis_real y[], const axis_real r[])
{
    const axis_real u = added(0, C[k], x, STATES);
    return added(added(u, D[k], y, MEASURED), DR[k], r, SET_POINTS);
}

#if AXIS_STATES > 0
/* What is remembered where the machine rests and y are its readings. */
static inline void begin(axis_real x[], const axis_real y[])
{
    for (int i = 0; i < STATES; i++)
        x[i] = added(0, START[i], y, MEASURED);
}

/* What is remembered of a tick, in which the limits added so much. */
static inline void remember(axis_real x[], const axis_real y[],
    const axis_real r[], const axis_real withheld[])
{
    axis_real next[AXIS_STATES];
    for (int i = 0; i < STATES; i++) {
        next[i] = added(0, A[i], x, STATES);
        next[i] = added(next[i], B[i], y, MEASURED);
        next[i] = added(next[i], BR[i], r, SET_POINTS);
        next[i] = added(next[i], W[i], withheld, OUTPUTS);
    }
    for (int i = 0; i < STATES; i++)
        x[i] = next[i];
}
#endif
#endif
