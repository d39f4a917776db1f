/* balance_steer.h: hold a heading beside balance.h
 *
 * (Where this comes from.)
 *
 * Use:   balance_steer_start() where balance_start() is called, and
 *        balance_steer() after each balance_step(). What balances is as
 *        without it: steering takes a share of what it leaves.
 *
 * Signs: a robot turns left where its right wheel rolls further. A radian
 *        of heading is BALANCE_PER_RADIAN rad of the wheels' difference.
 */
#ifndef BALANCE_STEER_H
#define BALANCE_STEER_H

#include "balance.h"

#ifdef __cplusplus
extern "C" {
#endif

/* All that steering remembers. Don't write into it. */
typedef struct {
    balance_real turned; /* rad, right wheel less left */
    balance_real zero;   /* rad, the same at the start */
    balance_real sum;    /* rad s, of the error */
    int lost;            /* ticks in a row with a bad encoder */
} balance_steering;

/* Forget everything; the robot rests.
 *   left, right  rad, the encoders' angles, wheels against body; not a
 *                number: the first reading after it counts as the start's */
void balance_steer_start(balance_steering *s, balance_real left,
    balance_real right);

/* One tick; writes the volts of the left and the right motor, 0 after a
 * fault.
 *   robot        after its balance_step() of this tick
 *   left, right  rad; not a number or out of reach: no steering now
 *   target       rad, set point of right less left since the start
 *   rate         rad/s, of the same */
void balance_steer(balance_steering *s, const balance_state *robot,
    balance_real left, balance_real right, balance_real target,
    balance_real rate, balance_real volts[2]);

#ifdef __cplusplus
}
#endif
#endif
