/* $name.c: see $name.h
 *
$note
 */
#include <float.h>
#include "$name.h"

$guards

$constants

/* u = C x + D y, then x+ = A x + B y + W (V - u). */
$matrices

/* False for what is not a number. */
static int within($real value, $real bound)
{
    return value >= -bound && value <= bound;
}

void ${name}_start(${name}_state *s, $real tilt, $real wheels, $real bias)
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
$start    s->bad = 0;
    s->lost = 0;
    s->same = 0;
    s->still = 0;
    s->full = 0;
    s->fault = ${NAME}_RUNNING;
}

$real ${name}_step(${name}_state *s, $real gyro, $real wheels, $real tilt,
    $real target, $real rate)
{
    if (s->fault != ${NAME}_RUNNING)
        return 0;

    /* A gyro that repeats itself for long is dead. */
    const $real last = gyro;
    const int same = FROZEN > 0 && gyro <= s->last && gyro >= s->last ?
        s->same + 1 : 0;

    /* After a bad reading all turns on as in the tick before. */
    gyro = gyro - s->bias;
    const int seen = within(gyro, RANGE);
    const int turned =
        within(wheels - s->wheels, REACH * ($real)(s->lost + 1));
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
    $real theta = s->theta + HALF_TICK * (gyro + s->gyro);
    if (within(tilt, TIP))
        theta = theta + BLEND * (tilt - theta);
    const $real phi = wheels + theta;
    const $real y[4] = {
        theta,
        phi - s->zero - target,
        gyro,
        (phi - s->phi) * HERTZ - rate,
    };

    /* The law and the voltage's limit. */
$alias$command    const $real V = u > LIMIT ? LIMIT : u < -LIMIT ? -LIMIT : u;
    const int full = u > LIMIT || u < -LIMIT ? s->full + 1 : 0;

    s->fault =
        bad > MISSING || lost > MISSING || same > FROZEN || still > DEAF ?
            ${NAME}_SENSOR :
        !within(theta, TIP) ? ${NAME}_FALL :
        !within(u, TRUSTED) ? ${NAME}_COMMAND :
        full > STALL ? ${NAME}_STALL : ${NAME}_RUNNING;
    if (s->fault != ${NAME}_RUNNING)
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
$next    return V;
}
