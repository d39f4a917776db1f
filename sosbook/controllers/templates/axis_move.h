/* axis_move.h: set points of moves from rest to rest, one each AXIS_MOVE_TICK s.
 *
 * (Where this comes from.)
 *
 * Velocity, acceleration and jerk of the set point stay within these limits, per
 * second. axis_move_to begins a move where the last one has ended; axis_move_next is
 * the set point for the next tick. All counters are integers: a move ends exactly.
 */
#ifndef AXIS_MOVE_H
#define AXIS_MOVE_H
#include <stdint.h>

@NUMBERS@
typedef struct {
    AXIS_MOVE_REAL from, to;
    int64_t n1, k, count, jump, bend, rate, place, whole;
} axis_move;

/* At rest at a set point. */
static inline void axis_move_start(axis_move *m, AXIS_MOVE_REAL r)
{
    const axis_move rest = {r, r, 1, 0, 0, 0, 0, 0, 0, 1};
    *m = rest;
}

/* 1: the move is over, and a next one may begin. */
static inline int axis_move_over(const axis_move *m)
{
    return m->k >= m->count;
}

/* 0: the last move isn't over, or the next one is too long to be counted. */
static inline int axis_move_to(axis_move *m, AXIS_MOVE_REAL r)
{
    const AXIS_MOVE_REAL far = r < m->to ? m->to - r : r - m->to;
    const AXIS_MOVE_REAL ticks = far / AXIS_MOVE_STEP;
    int64_t n1 = AXIS_MOVE_N1;
    if (!axis_move_over(m) || !(ticks < (AXIS_MOVE_REAL)AXIS_MOVE_MOST))
        return 0;
    if (ticks > (AXIS_MOVE_REAL)n1) {
        n1 = (int64_t)ticks;
        n1 += (AXIS_MOVE_REAL)n1 < ticks;
    }
    m->from = m->to;
    m->to = r;
    m->n1 = n1;
    m->k = m->jump = m->bend = m->rate = m->place = 0;
    m->count = n1 + AXIS_MOVE_N2 + AXIS_MOVE_N3 - 2;
    m->whole = n1 * AXIS_MOVE_N2 * AXIS_MOVE_N3;
    return 1;
}

/* The set point for the next tick. */
static inline AXIS_MOVE_REAL axis_move_next(axis_move *m)
{
    const int64_t n1 = m->n1, at[8] = {0, n1, AXIS_MOVE_N2, AXIS_MOVE_N3, n1 + AXIS_MOVE_N2, n1 + AXIS_MOVE_N3,
                                       AXIS_MOVE_N2 + AXIS_MOVE_N3, n1 + AXIS_MOVE_N2 + AXIS_MOVE_N3};
    static const int sign[8] = {1, -1, -1, -1, 1, 1, 1, -1};
    int i;
    if (axis_move_over(m))
        return m->to;
    for (i = 0; i < 8; i++)
        m->jump += at[i] == m->k ? sign[i] : 0;
    m->bend += m->jump;
    m->rate += m->bend;
    m->place += m->rate;
    m->k++;
    if (m->place == m->whole)
        return m->to;
    return m->from + (m->to - m->from) * ((AXIS_MOVE_REAL)m->place / (AXIS_MOVE_REAL)m->whole);
}

/* Follows set points that come tick by tick, within the same limits. */
typedef struct {
    AXIS_MOVE_REAL to;
    int64_t goal, ramp, sum[2], last[AXIS_MOVE_M2], means[AXIS_MOVE_M3];
    int at[2];
} axis_follow;

static inline int64_t axis_follow_counts(AXIS_MOVE_REAL x)
{
    const AXIS_MOVE_REAL half = (AXIS_MOVE_REAL)0.5;
    return (int64_t)(x < 0 ? x - half : x + half);
}

/* At rest at a set point. */
static inline void axis_follow_start(axis_follow *f, AXIS_MOVE_REAL r)
{
    const AXIS_MOVE_REAL counts = r / (AXIS_MOVE_REAL)AXIS_MOVE_UNIT;
    int i;
    f->to = r;
    f->goal = axis_follow_counts(counts);
    f->ramp = f->goal;
    f->sum[0] = f->goal * AXIS_MOVE_M2;
    f->sum[1] = f->goal * AXIS_MOVE_WHOLE;
    f->at[0] = f->at[1] = 0;
    for (i = 0; i < AXIS_MOVE_M2; i++)
        f->last[i] = f->goal;
    for (i = 0; i < AXIS_MOVE_M3; i++)
        f->means[i] = f->sum[0];
}

/* The set point for the next tick, on the way to r. No number, or too far: no new way. */
static inline AXIS_MOVE_REAL axis_follow_next(axis_follow *f, AXIS_MOVE_REAL r)
{
    const AXIS_MOVE_REAL counts = r / (AXIS_MOVE_REAL)AXIS_MOVE_UNIT;
    int64_t far;
    if (counts > -(AXIS_MOVE_REAL)AXIS_MOVE_LONGEST && counts < (AXIS_MOVE_REAL)AXIS_MOVE_LONGEST) {
        f->to = r;
        f->goal = axis_follow_counts(counts);
    }
    far = f->goal - f->ramp;
    f->ramp += far > AXIS_MOVE_FINEST ? AXIS_MOVE_FINEST : far < -AXIS_MOVE_FINEST ? -AXIS_MOVE_FINEST : far;
    f->sum[0] += f->ramp - f->last[f->at[0]];
    f->last[f->at[0]] = f->ramp;
    f->at[0] = (f->at[0] + 1) % AXIS_MOVE_M2;
    f->sum[1] += f->sum[0] - f->means[f->at[1]];
    f->means[f->at[1]] = f->sum[0];
    f->at[1] = (f->at[1] + 1) % AXIS_MOVE_M3;
    if (f->sum[1] == f->goal * AXIS_MOVE_WHOLE)
        return f->to;
    return (AXIS_MOVE_REAL)f->sum[1] / (AXIS_MOVE_REAL)AXIS_MOVE_WHOLE * (AXIS_MOVE_REAL)AXIS_MOVE_UNIT;
}

/* Come to rest within the limits: then give no number until there is a set point. */
static inline void axis_follow_stop(axis_follow *f)
{
    f->goal = f->ramp;
    f->to = (AXIS_MOVE_REAL)f->ramp * (AXIS_MOVE_REAL)AXIS_MOVE_UNIT;
}

#endif
