/* ${name}_steer.h: hold a heading beside $name.h
 *
$note
 *
 * Use:   ${name}_steer_start() where ${name}_start() is called, and
 *        ${name}_steer() after each ${name}_step(). What balances is as
 *        without it: steering takes a share of what it leaves.
 *
 * Signs: a robot turns left where its right wheel rolls further. A radian
 *        of heading is $per_radian rad of the wheels' difference.
 */
#ifndef ${NAME}_STEER_H
#define ${NAME}_STEER_H

#include "$name.h"

#ifdef __cplusplus
extern "C" {
#endif

/* All that steering remembers. Don't write into it. */
typedef struct {
    $real turned;  /* rad, right wheel less left */
    $real zero;    /* rad, the same at the start */
    $real sum;     /* rad s, of the error */
    int lost;      /* ticks in a row with a bad encoder */
} ${name}_steering;

/* Forget everything; the robot rests.
 *   left, right  rad, the encoders' angles, wheels against body; not a
 *                number: the first reading after it counts as the start's */
void ${name}_steer_start(${name}_steering *s, $real left, $real right);

/* One tick; writes the volts of the left and the right motor, 0 after a
 * fault.
 *   robot        after its ${name}_step() of this tick
 *   left, right  rad; not a number or out of reach: no steering now
 *   target       rad, set point of right less left since the start
 *   rate         rad/s, of the same */
void ${name}_steer(${name}_steering *s, const ${name}_state *robot,
    $real left, $real right, $real target, $real rate, $real volts[2]);

#ifdef __cplusplus
}
#endif
#endif
