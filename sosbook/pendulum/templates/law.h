/* $name.h: a control law for a mobile inverted pendulum
 *
$note
 *
 * Use:   ${name}_start() with the robot at rest, then ${name}_step() every
 *        $T s. Compile with -ffp-contract=off and never with
 *        -ffast-math; nothing else is needed, no library either.
 *
 * Signs: the body's angle theta is positive where it tips forward, the
 *        wheels' angle where they roll forward, and a positive voltage
 *        drives the wheels forward. Check all three by hand first.
 */
#ifndef ${NAME}_H
#define ${NAME}_H

#ifdef __cplusplus
extern "C" {
#endif

/* Why the motors are off. Only ${name}_start() ends a fault. */
enum {
$faults
};

/* All that the controller remembers. Don't write into it. */
typedef struct {
    $real bias;       /* rad/s, what the gyro says at rest */
    $real last;       /* rad/s, the gyro's last reading */
    $real gyro;       /* rad/s, theta' */
    $real theta;      /* rad, estimate of the body's angle */
    $real wheels;     /* rad, wheels against body, mean of both */
    $real increment;  /* rad, by which they turned in the last tick */
    $real zero;       /* rad, phi at the start */
    $real phi;        /* rad, wheels against the ground */
    $real volts;      /* V, what the motors got in the last tick */
$x    int bad;           /* ticks in a row with a bad gyro */
    int lost;          /* ticks in a row with bad encoders */
    int same;          /* ticks in a row with that very gyro */
    int still;         /* ticks in a row under voltage, wheels at rest */
    int full;          /* ticks in a row at the voltage's limit */
    int fault;         /* 0 while running */
} ${name}_state;

/* Forget everything; the robot rests.
 *   tilt    rad, theta from the accelerometers
 *   wheels  rad, the encoders' mean angle, wheels against body
 *   bias    rad/s, what the gyro says at rest */
void ${name}_start(${name}_state *s, $real tilt, $real wheels, $real bias);

/* One tick; returns the volts for both motors, 0 after a fault.
 *   gyro    rad/s; not a number or out of range: a bad reading
 *   wheels  rad, the encoders' mean angle; likewise
 *   tilt    rad, theta from the accelerometers; not a number or
 *           beyond $tip: there is none, which is no fault
 *   target  rad, set point of phi since the start
 *   rate    rad/s, set point of phi' */
$real ${name}_step(${name}_state *s, $real gyro, $real wheels, $real tilt,
    $real target, $real rate);

#ifdef __cplusplus
}
#endif
#endif
