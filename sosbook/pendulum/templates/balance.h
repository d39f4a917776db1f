/* balance.h: a control law for a mobile inverted pendulum
 *
 * (Where this comes from.)
 *
 * Use:   balance_start() with the robot at rest, then balance_step() every
 *        BALANCE_TICK_US microseconds. Compile as C99 with -ffp-contract=off,
 *        never with -ffast-math; nothing else is needed, no library either.
 *
 * Signs: the body's angle theta is positive where it tips forward, the
 *        wheels' angle where they roll forward, and a positive voltage
 *        drives the wheels forward. Check all three by hand first.
 */
#ifndef BALANCE_H
#define BALANCE_H

#include "balance_gains.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Why the motors are off. Only balance_start() ends a fault. */
enum {
    BALANCE_RUNNING = 0,  /* no fault */
    BALANCE_SENSOR = 1,  /* bad readings in a row, or repeated ones, or
                            wheels at rest under voltage: for too long */
    BALANCE_FALL = 2,  /* the body tilts too far */
    BALANCE_STALL = 3,  /* the voltage is at its limit for too long */
    BALANCE_COMMAND = 4, /* the law's answer is no number to trust */
    BALANCE_LATE = 5     /* ticks came late for too long: who calls says so */
};

#if BALANCE_SINGLE
typedef float balance_real;
#else
typedef double balance_real;
#endif

/* C has no array of nothing. */
#define BALANCE_ROOM(count) ((count) > 0 ? (count) : 1)

/* All that the controller remembers. Write nothing into it but BALANCE_LATE
   into fault, before balance_step(). */
typedef struct {
    balance_real bias;      /* rad/s, what the gyro says at rest */
    balance_real last;      /* rad/s, the gyro's last reading */
    balance_real gyro;      /* rad/s, theta' */
    balance_real theta;     /* rad, estimate of the body's angle */
    balance_real wheels;    /* rad, wheels against body, mean of both */
    balance_real increment; /* rad, by which they turned in the last tick */
    balance_real zero;      /* rad, phi at the start */
    balance_real phi;       /* rad, wheels against the ground */
    balance_real volts;     /* V, what the motors got in the last tick */
    balance_real x[BALANCE_ROOM(BALANCE_STATES)]; /* the law's memory */
    int bad;                /* ticks in a row with a bad gyro */
    int lost;               /* ticks in a row with bad encoders */
    int same;               /* ticks in a row with that very gyro */
    int still;              /* ticks in a row under voltage, wheels at rest */
    int full;               /* ticks in a row at the voltage's limit */
    int fault;              /* 0 while running */
} balance_state;

/* Forget everything; the robot rests.
 *   tilt    rad, theta from the accelerometers
 *   wheels  rad, the encoders' mean angle, wheels against body
 *   bias    rad/s, what the gyro says at rest */
void balance_start(balance_state *s, balance_real tilt, balance_real wheels,
    balance_real bias);

/* One tick; returns the volts for both motors, 0 after a fault.
 *   gyro    rad/s; not a number or out of range: a bad reading
 *   wheels  rad, the encoders' mean angle; likewise
 *   tilt    rad, theta from the accelerometers; not a number or
 *           beyond BALANCE_TIP: there is none, which is no fault
 *   target  rad, set point of phi since the start
 *   rate    rad/s, set point of phi' */
balance_real balance_step(balance_state *s, balance_real gyro,
    balance_real wheels, balance_real tilt, balance_real target,
    balance_real rate);

#ifdef __cplusplus
}
#endif
#endif
