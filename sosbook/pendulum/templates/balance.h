/* balance.h: a control law for a mobile inverted pendulum
 *
 * (Where this comes from.)
 *
 * Use:   balance_start() with the robot at rest, then balance_step() every
 *        0.01 s. Compile with -ffp-contract=off and never with
 *        -ffast-math; nothing else is needed, no library either.
 *
 * Signs: the body's angle theta is positive where it tips forward, the
 *        wheels' angle where they roll forward, and a positive voltage
 *        drives the wheels forward. Check all three by hand first.
 */
#ifndef BALANCE_H
#define BALANCE_H

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

#define BALANCE_ORDER 1 /* of the law */

/* All that the controller remembers. Write nothing into it but BALANCE_LATE
   into fault, before balance_step(). */
typedef struct {
    double bias;       /* rad/s, what the gyro says at rest */
    double last;       /* rad/s, the gyro's last reading */
    double gyro;       /* rad/s, theta' */
    double theta;      /* rad, estimate of the body's angle */
    double wheels;     /* rad, wheels against body, mean of both */
    double increment;  /* rad, by which they turned in the last tick */
    double zero;       /* rad, phi at the start */
    double phi;        /* rad, wheels against the ground */
    double volts;      /* V, what the motors got in the last tick */
#if BALANCE_ORDER > 0
    double x[BALANCE_ORDER]; /* the law's state */
#endif
    int bad;           /* ticks in a row with a bad gyro */
    int lost;          /* ticks in a row with bad encoders */
    int same;          /* ticks in a row with that very gyro */
    int still;         /* ticks in a row under voltage, wheels at rest */
    int full;          /* ticks in a row at the voltage's limit */
    int fault;         /* 0 while running */
} balance_state;

/* Forget everything; the robot rests.
 *   tilt    rad, theta from the accelerometers
 *   wheels  rad, the encoders' mean angle, wheels against body
 *   bias    rad/s, what the gyro says at rest */
void balance_start(balance_state *s, double tilt, double wheels, double bias);

/* One tick; returns the volts for both motors, 0 after a fault.
 *   gyro    rad/s; not a number or out of range: a bad reading
 *   wheels  rad, the encoders' mean angle; likewise
 *   tilt    rad, theta from the accelerometers; not a number or
 *           beyond 0.85 rad: there is none, which is no fault
 *   target  rad, set point of phi since the start
 *   rate    rad/s, set point of phi' */
double balance_step(balance_state *s, double gyro, double wheels, double tilt,
    double target, double rate);

#ifdef __cplusplus
}
#endif
#endif
