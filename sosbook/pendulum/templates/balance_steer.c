/* balance_steer.c: see balance_steer.h
 *
 * (Where this comes from.)
 */
#include "balance_steer.h"
#include "balance_tick.h"

static const balance_real TICK = BALANCE_TICK;
static const balance_real HERTZ = BALANCE_HERTZ;
static const balance_real LIMIT = BALANCE_LIMIT;
static const balance_real SHARE = BALANCE_SHARE;
static const balance_real REACH = BALANCE_STEER_REACH;
static const balance_real UNWIND = BALANCE_UNWIND;
static const balance_real TRUSTED = BALANCE_TRUSTED;
#define MOST_COUNTED 32766 /* ticks: what C promises of an int, less one */

/* W = K [error, its rate, sum], the right motor's volts less the left's. */
static const balance_real K[3] = BALANCE_K;

void balance_steer_start(balance_steering *s, balance_real left,
    balance_real right)
{
    s->turned = right - left;
    s->zero = s->turned;
    s->sum = 0;
    s->lost = 0;
}

/* Right less left, in volts, as far as balancing leaves them. */
static balance_real difference(balance_steering *s, balance_real V,
    balance_real turned, balance_real target, balance_real rate)
{
    /* A start without a reading: the first one is where the robot heads. */
    if (!within(s->turned, TRUSTED)) {
        s->turned = turned;
        s->zero = turned;
    }
    const balance_real since = (balance_real)(s->lost + 1);
    const balance_real y[3] = {
        turned - s->zero - target,
        (turned - s->turned) * HERTZ / since - rate,
        s->sum,
    };
    const balance_real u = added(0, K, y, 3);
    const balance_real rest = LIMIT - (V < 0 ? -V : V);
    const balance_real given = cut(u, 2 * (rest < SHARE ? rest : SHARE));
    if (!believable(turned - s->turned, REACH, s->lost) || !within(u, TRUSTED)) {
        s->lost = s->lost < MOST_COUNTED ? s->lost + 1 : s->lost;
        return 0;
    }
    s->sum = s->sum + TICK * y[0] + UNWIND * (given - u);
    s->turned = turned;
    s->lost = 0;
    return given;
}

void balance_steer(balance_steering *s, const balance_state *robot,
    balance_real left, balance_real right, balance_real target,
    balance_real rate, balance_real volts[2])
{
    volts[0] = 0;
    volts[1] = 0;
    if (robot->fault != BALANCE_RUNNING)
        return;
    const balance_real V = robot->volts;
    const balance_real half = difference(s, V, right - left, target, rate) / 2;
    volts[0] = cut(V - half, LIMIT);
    volts[1] = cut(V + half, LIMIT);
}
