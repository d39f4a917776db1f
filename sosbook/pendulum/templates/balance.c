/* balance.c: see balance.h
 *
 * (Where this comes from.)
 */
#include <float.h>
#include "balance.h"

#if defined __FAST_MATH__ || (defined __FINITE_MATH_ONLY__ && __FINITE_MATH_ONLY__)
#error "-ffast-math breaks the checks for what is not a number"
#endif
#if FLT_EVAL_METHOD != 0
#error "sums must round to their type at once: for x86 use -mfpmath=sse"
#endif
#if DBL_MANT_DIG != 53
#error "double has other digits than those that the header speaks of"
#endif

static const double HALF_TICK = 0x1.47ae147ae147bp-8;  /* 0.005 s */
static const double HERTZ = 0x1.9p+6;  /* 100 Hz */
static const double LIMIT = 0x1.d99999999999ap+2;  /* 7.4 V */
static const double TIP = 0x1.b333333333333p-1;  /* 0.85 rad */
static const double BLEND = 0x0p+0;  /* 0 of each tick's tilt */
static const double RANGE = 0x1.9p+6;  /* 100 rad/s */
static const double PUSH = 0x1.d99999999999ap+0;  /* 1.85 V */
static const double REACH = 0x1p+0;  /* 1 rad a tick */
static const double TRUSTED = 0x1.e848p+19;  /* 1000000 V */
static const int MISSING = 5;  /* ticks in a row */
static const int FROZEN = 0;  /* ticks in a row */
static const int DEAF = 0;  /* ticks in a row */
static const int STALL = 50;  /* ticks in a row */
#define COMPENSATES 0
#if COMPENSATES
static const double RUB = 0x0p+0;  /* 0 V, of friction that is compensated */
static const double SOFT = 0x0p+0;  /* 0 V, from which on all of it is */
static const double STEEP = 0x1p-1;  /* 0.5 V per V below */
#endif

/* u = C x + D y, then x+ = A x + B y + W (V - u). */
static const double A[1][1] = {
    {0x1p+0},
    /* 1 */
};
static const double B[1][4] = {
    {0x0p+0, 0x1.47ae147ae147bp-7, 0x0p+0, 0x0p+0},
    /* 0, 0.01, 0, 0 */
};
static const double W[1] = {
    0x1.999999999999ap-5,  /* 0.05 */
};
static const double C[1] = {
    0x1.999999999999ap-2,  /* 0.4 */
};
static const double D[4] = {
    0x1.4p+4,  /* 20 */
    0x1.999999999999ap-1,  /* 0.8 */
    0x1p+1,  /* 2 */
    0x1.ccccccccccccdp-1,  /* 0.9 */
};
static const double START[1] = {
    0x0p+0,  /* 0 */
};

/* False for what is not a number. */
static int within(double value, double bound)
{
    return value >= -bound && value <= bound;
}

void balance_start(balance_state *s, double tilt, double wheels, double bias)
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
#if BALANCE_ORDER > 0
    for (int i = 0; i < BALANCE_ORDER; i++)
        s->x[i] = START[i] * tilt;
#endif
    s->bad = 0;
    s->lost = 0;
    s->same = 0;
    s->still = 0;
    s->full = 0;
    s->fault = BALANCE_RUNNING;
}

double balance_step(balance_state *s, double gyro, double wheels, double tilt,
    double target, double rate)
{
    if (s->fault != BALANCE_RUNNING)
        return 0;

    /* A gyro that repeats itself for long is dead. */
    const double last = gyro;
    const int same = FROZEN > 0 && gyro <= s->last && gyro >= s->last ?
        s->same + 1 : 0;

    /* After a bad reading all turns on as in the tick before. */
    gyro = gyro - s->bias;
    const int seen = within(gyro, RANGE);
    const int turned =
        within(wheels - s->wheels, REACH * (double)(s->lost + 1));
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
    double theta = s->theta + HALF_TICK * (gyro + s->gyro);
    if (within(tilt, TIP))
        theta = theta + BLEND * (tilt - theta);
    const double phi = wheels + theta;
    const double y[4] = {
        theta,
        phi - s->zero - target,
        gyro,
        (phi - s->phi) * HERTZ - rate,
    };

    /* The law and the voltage's limit. */
    double u =
        C[0] * s->x[0] + D[0] * y[0] + D[1] * y[1] + D[2] * y[2] +
            D[3] * y[3];
#if COMPENSATES
    u = u + (u > SOFT ? RUB : u < -SOFT ? -RUB : STEEP * u); /* against friction */
#endif
    const double V = u > LIMIT ? LIMIT : u < -LIMIT ? -LIMIT : u;
    const int full = u > LIMIT || u < -LIMIT ? s->full + 1 : 0;

    s->fault =
        bad > MISSING || lost > MISSING || same > FROZEN || still > DEAF ?
            BALANCE_SENSOR :
        !within(theta, TIP) ? BALANCE_FALL :
        !within(u, TRUSTED) ? BALANCE_COMMAND :
        full > STALL ? BALANCE_STALL : BALANCE_RUNNING;
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
#if BALANCE_ORDER > 0
    const double next[BALANCE_ORDER] = {
        A[0][0] * s->x[0] + B[0][1] * y[1] + W[0] * (V - u),
    };
    for (int i = 0; i < BALANCE_ORDER; i++)
        s->x[i] = next[i];
#endif
    return V;
}
