/* balance.c: see balance.h
 *
 * (Where this comes from.)
 */
#include "balance_tick.h"

static const balance_real HALF_TICK = BALANCE_HALF_TICK;
static const balance_real HERTZ = BALANCE_HERTZ;
static const balance_real LIMIT = BALANCE_LIMIT;
static const balance_real TIP = BALANCE_TIP;
static const balance_real BLEND = BALANCE_BLEND;
static const balance_real RANGE = BALANCE_RANGE;
static const balance_real PUSH = BALANCE_PUSH;
static const balance_real REACH = BALANCE_REACH;
static const balance_real TRUSTED = BALANCE_TRUSTED;
static const int MOST_LOST = BALANCE_MOST_LOST;
static const int FROZEN = BALANCE_FROZEN;
static const int DEAF = BALANCE_DEAF;
static const int MOST_FULL = BALANCE_MOST_FULL;
#if BALANCE_COMPENSATES
static const balance_real RUB = BALANCE_RUB;
static const balance_real SOFT = BALANCE_SOFT;
static const balance_real STEEP = BALANCE_STEEP;
#endif

void balance_start(balance_state *s, balance_real tilt, balance_real wheels,
    balance_real bias)
{
    s->bias = bias;
    s->last = bias;
    s->gyro = 0;
    s->theta = tilt;
    s->wheels = wheels;
    s->increment = 0;
    s->phi = wheels + tilt;
    s->zero = s->phi;
    s->volts = 0;
#if BALANCE_STATES > 0
    const balance_real y[BALANCE_MEASURED] = {tilt, 0, 0, 0};
    begin(s->x, y);
#endif
    s->bad = 0;
    s->lost = 0;
    s->same = 0;
    s->still = 0;
    s->full = 0;
    s->fault = BALANCE_RUNNING;
}

balance_real balance_step(balance_state *s, balance_real gyro,
    balance_real wheels, balance_real tilt, balance_real target,
    balance_real rate)
{
    if (s->fault != BALANCE_RUNNING)
        return 0;

    /* A gyro that repeats itself for long is dead. */
    const balance_real last = gyro;
    const int same = FROZEN > 0 && gyro <= s->last && gyro >= s->last ?
        s->same + 1 : 0;

    /* After a bad reading all turns on as in the tick before. */
    gyro = gyro - s->bias;
    const int seen = within(gyro, RANGE);
    const int turned = believable(wheels - s->wheels, REACH, s->lost);
    const int bad = seen ? 0 : s->bad + 1;
    const int lost = turned ? 0 : s->lost + 1;

    /* Wheels that rest under voltage: an encoder that lost its wire. */
    const int still = DEAF > 0 && !within(s->volts, PUSH) &&
        wheels <= s->wheels && wheels >= s->wheels ? s->still + 1 : 0;
    if (!seen)
        gyro = s->gyro;
    if (!turned)
        wheels = s->wheels + s->increment;

    /* The gyro's integral by the trapezoidal rule, corrected slowly. */
    balance_real theta = s->theta + HALF_TICK * (gyro + s->gyro);
    if (within(tilt, TIP))
        theta = theta + BLEND * (tilt - theta);
    const balance_real phi = wheels + theta;
    const balance_real y[BALANCE_MEASURED] = {
        theta,
        phi - s->zero - target,
        gyro,
        (phi - s->phi) * HERTZ - rate,
    };

    /* The law and the voltage's limit. */
    balance_real u = answered(0, s->x, y, y);
#if BALANCE_COMPENSATES
    u = u + (u > SOFT ? RUB : u < -SOFT ? -RUB : STEEP * u); /* against friction */
#endif
    const balance_real V = cut(u, LIMIT);
    const int full = u > LIMIT || u < -LIMIT ? s->full + 1 : 0;

    s->fault =
        bad > MOST_LOST || lost > MOST_LOST || same > FROZEN || still > DEAF ?
            BALANCE_SENSOR :
        !within(theta, TIP) ? BALANCE_FALL :
        !within(u, TRUSTED) ? BALANCE_COMMAND :
        full > MOST_FULL ? BALANCE_STALL : BALANCE_RUNNING;
    if (s->fault != BALANCE_RUNNING)
        return 0;

    s->increment = wheels - s->wheels;
    s->theta = theta;
    s->gyro = gyro;
    s->wheels = wheels;
    s->phi = phi;
    s->last = last;
    s->volts = V;
    s->bad = bad;
    s->lost = lost;
    s->same = same;
    s->still = still;
    s->full = full;
#if BALANCE_STATES > 0
    const balance_real withheld = V - u;
    remember(s->x, y, y, &withheld);
#endif
    return V;
}
