/* balance_steer.c: see balance_steer.h
 *
 * (Where this comes from.)
 */
#include <float.h>
#include "balance_steer.h"

#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__)
#error "-ffast-math breaks the checks for what is not a number"
#endif
#if FLT_EVAL_METHOD != 0
#error "sums must round to their type at once: for x86 use -mfpmath=sse"
#endif
#if DBL_MANT_DIG != 53
#error "double has other digits than those that the header speaks of"
#endif

static const double TICK = 0x1.47ae147ae147bp-7;  /* 0.01 s */
static const double HERTZ = 0x1.9p+6;  /* 100 Hz */
static const double LIMIT = 0x1.d99999999999ap+2;  /* 7.4 V */
static const double SHARE = 0x1.d99999999999ap+0;  /* 1.85 V, for steering */
static const double REACH = 0x1p+1;  /* 2 rad a tick */
static const double UNWIND = -0x1.47ae147ae147bp-5;  /* -0.04 rad s per V */
static const double TRUSTED = 0x1.e848p+19;  /* 1000000 V */
#define MOST_LOST 32766 /* ticks: what C promises of an int, less one */

/* W = K [error, its rate, sum], the right motor's volts less the left's. */
static const double K[3] = {
    -0x1p+0,  /* -1 */
    -0x1.999999999999ap-4,  /* -0.1 */
    -0x1p-1,  /* -0.5 */
};

/* False for what is not a number. */
static int within(double value, double bound)
{
    return value >= -bound && value <= bound;
}

static double cut(double value, double bound)
{
    return value > bound ? bound : value < -bound ? -bound : value;
}

void balance_steer_start(balance_steering *s, double left, double right)
{
    s->turned = right - left;
    s->zero = s->turned;
    s->sum = 0;
    s->lost = 0;
}

/* Right less left, in volts, as far as balancing leaves them. */
static double difference(balance_steering *s, double V, double turned,
    double target, double rate)
{
    /* A start without a reading: the first one is where the robot heads. */
    if (!within(s->turned, DBL_MAX)) {
        s->turned = turned;
        s->zero = turned;
    }
    const double since = (double)(s->lost + 1);
    const double y[3] = {
        turned - s->zero - target,
        (turned - s->turned) * HERTZ / since - rate,
        s->sum,
    };
    const double u = K[0] * y[0] + K[1] * y[1] + K[2] * y[2];
    const double rest = LIMIT - (V < 0 ? -V : V);
    const double W = cut(u, 2 * (rest < SHARE ? rest : SHARE));
    if (!within(turned - s->turned, REACH * since) || !within(u, TRUSTED)) {
        s->lost = s->lost < MOST_LOST ? s->lost + 1 : s->lost;
        return 0;
    }
    s->sum = s->sum + TICK * y[0] + UNWIND * (W - u);
    s->turned = turned;
    s->lost = 0;
    return W;
}

void balance_steer(balance_steering *s, const balance_state *robot,
    double left, double right, double target, double rate, double volts[2])
{
    volts[0] = 0;
    volts[1] = 0;
    if (robot->fault != BALANCE_RUNNING)
        return;
    const double V = robot->volts;
    const double half = difference(s, V, right - left, target, rate) / 2;
    volts[0] = cut(V - half, LIMIT);
    volts[1] = cut(V + half, LIMIT);
}
