/* balance_run.h: what every program does around the law of balance.h
 *
 * (Where this comes from.)
 *
 * It waits until the robot is held still near upright for a second, takes the
 * gyro's mean as its offset, and balances: it minds the clock, moves the set
 * points on ramps, and holds the heading where BALANCE_STEERS is 1.
 *
 * Use:   a balance_run that is zero, then balance_run_tick() at every tick.
 *        Who calls reads the sensors, obeys commands and drives the motors.
 *        Link the library of mathematics, for a square root.
 */
#ifndef BALANCE_RUN_H
#define BALANCE_RUN_H

#include "balance.h"
#if BALANCE_STEERS
#include "balance_steer.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    /* What is wanted; write it at any time. Without a command for a second,
       write zeros. Beyond the robot's limits it gets those. */
    balance_real speed;   /* rad/s, of the wheels */
    balance_real turn;    /* rad/s, of the heading, positive to the left */
    balance_real place;   /* rad since the start, where to go and to stay */
    balance_real bearing; /* rad, the heading there */
    int going;     /* 0: speed and turn, 1: place, 2: place and bearing */

    /* What is done; don't write into it. */
    int balancing; /* 1 from the start to balance_run_stop() */
    long late;     /* ticks, all that came late */
    const char *waiting; /* why it doesn't start; empty: it will */
    balance_real volts;    /* V, what the law answered */
    balance_real motor[2]; /* V, of the left and the right motor */
    balance_real target, rate;       /* set points of phi and phi' */
    balance_real heading, turn_rate; /* rad and rad/s, set points */
    balance_real theta;    /* rad, its estimate */
    balance_real bias;     /* rad/s, what the gyro says at rest */
    int fault;             /* why the motors are off, as in balance.h */
    long overdue;  /* ticks that came late, or not at all, less the others */
    int calm;      /* ticks at rest so far */
    balance_real gyro_sum, tilt_sum, wheels_at_rest;
    balance_state law;
#if BALANCE_STEERS
    balance_steering steering;
#endif
} balance_run;

/* What a tick was: at the start the motors get nothing yet. */
enum { BALANCE_WAITED = 0, BALANCE_STARTED = 1, BALANCE_BALANCED = 2 };

/* One tick; with a fault the motors get nothing: stop it.
 *   gyro, tilt   rad/s and rad, as balance_step() has them
 *   left, right  rad, the encoders' angles, wheels against body
 *   elapsed      s since the last tick, by a clock that doesn't stop */
int balance_run_tick(balance_run *s, balance_real gyro, balance_real left,
    balance_real right, balance_real tilt, balance_real elapsed);

/* The motors are off: wait for rest again. */
void balance_run_stop(balance_run *s);

/* The volts of each motor from a battery of so many: standing comes first. */
void balance_run_volts(const balance_run *s, balance_real battery,
    balance_real volts[2]);

#ifdef __cplusplus
}
#endif
#endif
