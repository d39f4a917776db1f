/* axis.h: a digital controller
 *
 * (Where this comes from.)
 *
 * Use:   axis_start() with the first readings, then axis_step() every
 *        AXIS_TICK seconds. Write its outputs to the actuators AXIS_DELAY
 *        seconds after the readings were taken, not earlier and not later.
 *        Compile as C99 with -ffp-contract=off, never with -ffast-math or
 *        -ffinite-math-only; nothing else is needed, no library either.
 *
 * A second machine needs a second axis_state and nothing else. There is no
 * heap, no recursion, no global variable that changes, and every tick takes
 * the same steps.
 */
#ifndef AXIS_H
#define AXIS_H

#include "axis_gains.h"

#ifdef __cplusplus
extern "C" {
#endif

#if AXIS_SINGLE
typedef float axis_real;
#else
typedef double axis_real;
#endif

/* C has no array of nothing. */
#define AXIS_ROOM(count) ((count) > 0 ? (count) : 1)

/* Why the outputs are off. Only axis_start() ends a fault. */
enum {
    AXIS_RUNNING = 0, /* no fault */
    AXIS_SENSOR = 1,  /* no sample to believe, for too long */
    AXIS_CLOCK = 2,   /* ticks came too early or too late, for too long */
    AXIS_STALL = 3,   /* an output was at its limit for too long */
    AXIS_COMMAND = 4, /* the law's answer is no number to trust */
    AXIS_SILENT = 5   /* nobody gave a set point for too long */
};

/* All that the controller remembers. Don't write into it. */
typedef struct {
    axis_real x[AXIS_ROOM(AXIS_STATES)];     /* its memory: see AXIS_A */
    axis_real y[AXIS_MEASURED];              /* the last believed samples */
    axis_real r[AXIS_ROOM(AXIS_SET_POINTS)]; /* set points after the ramp */
    axis_real u[AXIS_OUTPUTS];               /* the last outputs */
    int lost[AXIS_MEASURED]; /* ticks in a row without a sample to believe */
    int late;                /* ticks in a row that came early or late */
    int silent;              /* watched ticks in a row without a set point */
    int full;                /* ticks in a row with an output at its limit */
    int overruns;            /* all ticks that came early or late */
    int fault;               /* 0 while running */
} axis_state;

/* Forget everything. The machine rests; y are its readings. */
void axis_start(axis_state *s, const axis_real y[]);

/* One tick; returns the fault, 0 while running.
 *   y        the readings; not a number or out of range: a lost sample
 *   r        the set points; not a number: no new one
 *   elapsed  s since the last tick, by a clock that doesn't stop; give
 *            AXIS_TICK where a timer guarantees it
 *   u        the outputs; zero after a fault */
int axis_step(axis_state *s, const axis_real y[], const axis_real r[],
    axis_real elapsed, axis_real u[]);

#ifdef __cplusplus
}
#endif
#endif
