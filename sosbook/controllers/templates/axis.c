/* axis.c: see axis.h
 *
 * (Where this comes from.)
 */
#include "axis_tick.h"

enum { MOST_OVERRUNS = 30000 /* counted; then the counter stays */ };

#if AXIS_PREDICTS
/* What is taken for a sample that is lost. */
static const axis_real GUESS[AXIS_MEASURED][AXIS_ROOM(AXIS_STATES)] =
    AXIS_GUESS;
#endif
static const int FOLLOWED[AXIS_ROOM(AXIS_SET_POINTS)] = AXIS_FOLLOWED;

static const axis_real LIMIT[AXIS_OUTPUTS] = AXIS_LIMIT;
#if AXIS_SLEWS
static const axis_real SLEW[AXIS_OUTPUTS] = AXIS_SLEW;
#endif
#if AXIS_RAMPS
static const axis_real RAMP[AXIS_ROOM(AXIS_SET_POINTS)] = AXIS_RAMP;
#endif
static const axis_real RANGE[AXIS_MEASURED] = AXIS_RANGE;
static const axis_real JUMP[AXIS_MEASURED] = AXIS_JUMP;
static const axis_real REACH[AXIS_ROOM(AXIS_SET_POINTS)] = AXIS_REACH;
static const axis_real TRUSTED[AXIS_OUTPUTS] = AXIS_TRUSTED;
static const axis_real TICK = AXIS_TICK;
static const axis_real SLACK = AXIS_SLACK;

void axis_start(axis_state *s, const axis_real y[])
{
    int good = 1;
    for (int i = 0; i < MEASURED; i++)
        good = good && within(y[i], RANGE[i]);
    for (int i = 0; i < MEASURED; i++) {
        s->y[i] = good ? y[i] : 0;
        s->lost[i] = 0;
    }
#if AXIS_STATES > 0
    begin(s->x, s->y);
#endif
    for (int j = 0; j < SET_POINTS; j++)
        s->r[j] = FOLLOWED[j] < 0 ? 0 : s->y[FOLLOWED[j]];
    for (int k = 0; k < OUTPUTS; k++)
        s->u[k] = 0;
    s->late = 0;
    s->silent = 0;
    s->full = 0;
    s->overruns = 0;
    s->fault = good ? AXIS_RUNNING : AXIS_SENSOR;
}

/* The outputs are off, for this reason. */
static int off(axis_state *s, int fault, axis_real u[])
{
    for (int k = 0; k < OUTPUTS; k++) {
        s->u[k] = 0;
        u[k] = 0;
    }
    s->fault = fault;
    return fault;
}

int axis_step(axis_state *s, const axis_real y[], const axis_real r[],
    axis_real elapsed, axis_real u[])
{
    axis_real seen[AXIS_MEASURED];
    axis_real follows[AXIS_ROOM(AXIS_SET_POINTS)];
#if AXIS_STATES > 0
    axis_real withheld[AXIS_OUTPUTS];
#endif
    int believed[AXIS_MEASURED], fault = AXIS_RUNNING, full = 0, told = 1;

    if (s->fault != AXIS_RUNNING)
        return off(s, s->fault, u);

    /* The clock: the law is for ticks of TICK seconds. */
    const int late = within(elapsed - TICK, SLACK) ? 0 : s->late + 1;
    const int overruns = s->overruns + (late > 0 && s->overruns < MOST_OVERRUNS);
    if (late > AXIS_MOST_LATE)
        fault = AXIS_CLOCK;

    /* The sensors: a sample that is lost, or jumps, is replaced. */
    for (int i = 0; i < MEASURED; i++) {
        believed[i] = within(y[i], RANGE[i]) &&
            believable(y[i] - s->y[i], JUMP[i], s->lost[i]);
#if AXIS_PREDICTS
        seen[i] = believed[i] ? y[i] : added(0, GUESS[i], s->x, STATES);
#else
        seen[i] = believed[i] ? y[i] : s->y[i];
#endif
        if (!believed[i] && s->lost[i] + 1 > AXIS_MOST_LOST && !fault)
            fault = AXIS_SENSOR;
    }

    /* The set points, no faster than their ramps. */
    follows[0] = 0;
    for (int j = 0; j < SET_POINTS; j++) {
        const int good = within(r[j], REACH[j]);
#if AXIS_RAMPS
        const axis_real goal = s->r[j] + cut(r[j] - s->r[j], RAMP[j]);
#else
        const axis_real goal = r[j];
#endif
        follows[j] = good ? goal : s->r[j];
        told = told && good;
    }
    const int silent = told || !AXIS_MOST_SILENT ? 0 : s->silent + 1;
    if (silent > AXIS_MOST_SILENT && !fault)
        fault = AXIS_SILENT;

    /* The law and its limits. */
    for (int k = 0; k < OUTPUTS; k++) {
        const axis_real want = answered(k, s->x, seen, follows);
        if (!within(want, TRUSTED[k]) && !fault)
            fault = AXIS_COMMAND;
        full = full || want > LIMIT[k] || want < -LIMIT[k];
        u[k] = cut(want, LIMIT[k]);
#if AXIS_SLEWS
        u[k] = cut(s->u[k] + cut(u[k] - s->u[k], SLEW[k]), LIMIT[k]);
#endif
#if AXIS_STATES > 0
        withheld[k] = u[k] - want;
#endif
    }
    full = full ? s->full + 1 : 0;
    if (full > AXIS_MOST_FULL && !fault)
        fault = AXIS_STALL;
    if (fault)
        return off(s, fault, u);

    /* What is remembered. */
#if AXIS_STATES > 0
    remember(s->x, seen, follows, withheld);
#endif
    for (int i = 0; i < MEASURED; i++) {
        s->lost[i] = believed[i] ? 0 : s->lost[i] + 1;
        s->y[i] = believed[i] ? y[i] : s->y[i];
    }
    for (int j = 0; j < SET_POINTS; j++)
        s->r[j] = follows[j];
    for (int k = 0; k < OUTPUTS; k++)
        s->u[k] = u[k];
    s->late = late;
    s->silent = silent;
    s->full = full;
    s->overruns = overruns;
    return AXIS_RUNNING;
}
