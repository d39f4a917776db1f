/* balance_run.c: see balance_run.h
 *
 * (Where this comes from.)
 */
#include <math.h>
#include "balance_run.h"
#include "balance_tick.h"

static const balance_real TICK = BALANCE_TICK;
static const balance_real HERTZ = BALANCE_HERTZ;
static const balance_real SPEED = BALANCE_SPEED;
static const balance_real ACCELERATION = BALANCE_ACCELERATION;
#if BALANCE_STEERS
static const balance_real TURN_RATE = BALANCE_TURN_RATE;
static const balance_real TURN_ACCELERATION = BALANCE_TURN_ACCELERATION;
static const balance_real PER_RADIAN = BALANCE_PER_RADIAN;
#endif
static const balance_real SLACK = BALANCE_SLACK;
static const long MOST_LATE = BALANCE_MOST_LATE;
#define GENTLE ((balance_real)0.3) /* of the ramps, to a place: hardly passed */

/* At rest near upright: all readings of a second lie within. */
static const int REST_TICKS = BALANCE_REST_TICKS;
#define REST_TILT ((balance_real)0.2) /* rad */
#define REST_GYRO ((balance_real)0.1) /* rad/s */
#define REST_TURN ((balance_real)0.05) /* rad, of the wheels */

#if BALANCE_SINGLE
#define FARTHEST 1e4f /* rad, of a place: a float's digits end there */
#define root sqrtf
#else
#define FARTHEST 1e6 /* rad */
#define root sqrt
#endif

static int at_rest(balance_run *s, balance_real gyro, balance_real wheels,
    balance_real tilt)
{
    const int upright = within(tilt, REST_TILT), still = within(gyro, REST_GYRO);
    if (s->calm == 0 || !upright || !still ||
        !within(wheels - s->wheels_at_rest, REST_TURN)) {
        s->waiting = !upright ? "hold it upright" :
            !still ? "hold it still: the gyro turns, or its offset is large" :
            s->calm > 0 ? "hold its wheels still" : "";
        s->wheels_at_rest = wheels;
        s->gyro_sum = s->tilt_sum = 0;
        s->calm = 1;
        return 0;
    }
    s->gyro_sum += gyro;
    s->tilt_sum += tilt;
    return s->calm++ == REST_TICKS;
}

/* What the law knows that others ask for. */
static void told(balance_run *s)
{
    s->theta = s->law.theta;
    s->fault = s->law.fault;
}

static void start(balance_run *s, balance_real left, balance_real right)
{
    const balance_real ticks = (balance_real)REST_TICKS;
    balance_start(&s->law, s->tilt_sum / ticks, (left + right) / 2,
        s->gyro_sum / ticks);
#if BALANCE_STEERS
    balance_steer_start(&s->steering, left, right);
#endif
    s->target = s->rate = s->heading = s->turn_rate = 0;
    s->volts = s->motor[0] = s->motor[1] = 0;
    s->going = 0;
    s->late = s->overdue = 0;
    s->bias = s->law.bias;
    s->balancing = 1;
    told(s);
}

/* A tick that comes late makes phi' wrong, and with it the law. Other than in
 * axis.c a short one after it is good, for a board catches up by it, and a
 * tick that never came counts. */
static void mind(balance_run *s, balance_real elapsed)
{
    const balance_real by = elapsed - TICK;
    if (by > SLACK) {
        s->late++;
        s->overdue += 1 + (long)cut(by * HERTZ, HERTZ);
    } else if (s->overdue > 0) {
        s->overdue--;
    }
    if (MOST_LATE > 0 && s->overdue > MOST_LATE)
        s->law.fault = BALANCE_LATE;
}

/* The speed from which it stops just when nothing is left. */
static balance_real stopping(balance_real left, balance_real most,
    balance_real acceleration)
{
    const balance_real way = left < 0 ? -left : left, step = acceleration / HERTZ;
    const balance_real speed =
        root(step * step / 4 + 2 * acceleration * way) - step / 2;
    return cut(left * HERTZ, speed < most ? speed : most);
}

/* Move a set point and its rate towards what is wanted. */
static void move(balance_real *target, balance_real *rate, balance_real wanted,
    balance_real acceleration)
{
    *rate += cut(wanted - *rate, acceleration / HERTZ);
    *target += *rate / HERTZ;
}

static void ramp(balance_run *s)
{
    const int good = within(s->speed, FARTHEST) && within(s->turn, FARTHEST);
    const int to = within(s->place, FARTHEST) && within(s->bearing, FARTHEST) ?
        s->going : 0;
    const balance_real share = to ? GENTLE : 1, a = share * ACCELERATION;
    move(&s->target, &s->rate, to ? stopping(s->place - s->target, SPEED, a) :
        good ? cut(s->speed, SPEED) : 0, a);
#if BALANCE_STEERS
    const balance_real b = share * TURN_ACCELERATION;
    move(&s->heading, &s->turn_rate, to == 2 ?
        stopping(s->bearing - s->heading, share * TURN_RATE, b) :
        good && !to ? cut(s->turn, TURN_RATE) : 0, b);
#endif
}

int balance_run_tick(balance_run *s, balance_real gyro, balance_real left,
    balance_real right, balance_real tilt, balance_real elapsed)
{
    const balance_real wheels = (left + right) / 2;
    if (!s->balancing) {
        if (!at_rest(s, gyro, wheels, tilt))
            return BALANCE_WAITED;
        start(s, left, right);
        return BALANCE_STARTED;
    }
    mind(s, elapsed);
    ramp(s);
    s->volts = balance_step(&s->law, gyro, wheels, tilt, s->target, s->rate);
    s->motor[0] = s->motor[1] = s->volts;
#if BALANCE_STEERS
    balance_steer(&s->steering, &s->law, left, right, PER_RADIAN * s->heading,
        PER_RADIAN * s->turn_rate, s->motor);
#endif
    told(s);
    return BALANCE_BALANCED;
}

void balance_run_stop(balance_run *s)
{
    s->balancing = 0;
    s->calm = 0;
}

void balance_run_volts(const balance_run *s, balance_real battery,
    balance_real volts[2])
{
    const balance_real mean = cut((s->motor[0] + s->motor[1]) / 2, battery);
    const balance_real half = cut((s->motor[1] - s->motor[0]) / 2,
        battery - (mean < 0 ? -mean : mean));
    volts[0] = mean - half;
    volts[1] = mean + half;
}
