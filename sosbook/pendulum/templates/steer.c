/* ${name}_steer.c: see ${name}_steer.h
 *
$note
 */
#include <float.h>
#include "${name}_steer.h"

$guards

$constants

/* W = K [error, its rate, sum], the right motor's volts less the left's. */
static const $real K[3] = $gain;

/* False for what is not a number. */
static int within($real value, $real bound)
{
    return value >= -bound && value <= bound;
}

static $real cut($real value, $real bound)
{
    return value > bound ? bound : value < -bound ? -bound : value;
}

void ${name}_steer_start(${name}_steering *s, $real left, $real right)
{
    s->turned = right - left;
    s->zero = s->turned;
    s->sum = 0;
    s->lost = 0;
}

/* Right less left, in volts, as far as balancing leaves them. */
static $real difference(${name}_steering *s, $real V, $real turned,
    $real target, $real rate)
{
    /* A start without a reading: the first one is where the robot heads. */
    if (!within(s->turned, ${largest})) {
        s->turned = turned;
        s->zero = turned;
    }
    const $real since = ($real)(s->lost + 1);
    const $real y[3] = {
        turned - s->zero - target,
        (turned - s->turned) * HERTZ / since - rate,
        s->sum,
    };
    const $real u = $output;
    const $real rest = LIMIT - (V < 0 ? -V : V);
    const $real W = cut(u, 2 * (rest < SHARE ? rest : SHARE));
    if (!within(turned - s->turned, REACH * since) || !within(u, TRUSTED)) {
        s->lost = s->lost < $most ? s->lost + 1 : s->lost;
        return 0;
    }
    s->sum = s->sum + TICK * y[0] + UNWIND * (W - u);
    s->turned = turned;
    s->lost = 0;
    return W;
}

void ${name}_steer(${name}_steering *s, const ${name}_state *robot,
    $real left, $real right, $real target, $real rate, $real volts[2])
{
    volts[0] = 0;
    volts[1] = 0;
    if (robot->fault != ${NAME}_RUNNING)
        return;
    const $real V = robot->volts;
    const $real half = difference(s, V, right - left, target, rate) / 2;
    volts[0] = cut(V - half, LIMIT);
    volts[1] = cut(V + half, LIMIT);
}
