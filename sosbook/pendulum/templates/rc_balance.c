/* rc_$name.c: balance a BeagleBone Blue robot with librobotcontrol
 *
$note
 *
 * Build on the robot:
 *   gcc -std=gnu99 -O2 -ffp-contract=off rc_$name.c $name.c \
 *       -o rc_$name -lrobotcontrol -lm -pthread
 *
 * FIRST check the signs on a stand, wheels in the air, PAUSE at hand:
 *   1. "rc_$name check" prints what the sensors say, motors off. Tip
 *      the robot forward: tilt and gyro are positive. Upright and at
 *      rest: tilt is zero, or correct BOARD_MOUNT_ANGLE. Roll each
 *      wheel forward: its encoder grows.
 *   2. Run the stand's program, with the body's gains alone and 2 V.
 *      Tip the robot forward: both wheels run forward, as if to catch
 *      it. If they don't, change motor_polarities in the robot's
 *      description and write the programs again. Don't try it with a
 *      program that balances: in the air its wheels race.
 *
 * Running: the robot waits until it is held still near upright for a
 * second, takes the gyro's mean as its offset, and balances. PAUSE
 * stops it and lets it wait again; hold PAUSE for two seconds to end.
 */
#include <stdio.h>
#include <robotcontrol.h>
#include "$name.h"

#define RATE_HZ $hertz

/* The robot's description. */
#define BOARD_MOUNT_ANGLE $mount /* rad, of the board in the body */
#define COUNTS $counts /* of an encoder, per turn of a wheel */
#define V_NOMINAL $nominal /* V, where the battery isn't measured */
#define V_LOW $low /* V; a battery below isn't measured */
#define V_HIGH $high /* V; nor one above */

/* Left and right. */
static const int MOTOR_CHANNEL[2] = $motor_channels;
static const int MOTOR_POLARITY[2] = $motor_polarities;
static const int ENCODER_CHANNEL[2] = $encoder_channels;
static const int ENCODER_POLARITY[2] = $encoder_polarities;

/* At rest near upright: all readings of a second lie within. */
#define REST_TICKS RATE_HZ
#define REST_TILT 0.2  /* rad */
#define REST_GYRO 0.1  /* rad/s */
#define REST_TURN 0.05 /* rad, of the wheels */

static const double TURN = 6.283185307179586; /* rad */
static const char *const REASON[] = {$reasons};

/* The callback alone writes these. */
static rc_mpu_data_t imu;
static ${name}_state robot;
static int balancing;
static int calm;            /* ticks at rest so far */
static double gyro_sum, tilt_sum, wheels_at_rest;
static volatile int reason; /* the last fault */
static volatile unsigned ticks;

/* The main loop alone writes this: millivolts, for an int is atomic. */
static volatile int battery = (int)(1000 * V_NOMINAL);

/* rad, theta: about the IMU's x axis, forward is positive */
static double read_tilt(void)
{
    return imu.dmp_TaitBryan[TB_PITCH_X] + BOARD_MOUNT_ANGLE;
}

/* rad/s, theta' */
static double read_gyro(void)
{
    return imu.gyro[0] * DEG_TO_RAD;
}

/* rad, a wheel against the body, forward is positive */
static double read_wheel(int side)
{
    return rc_encoder_eqep_read(ENCODER_CHANNEL[side]) * TURN
        / (ENCODER_POLARITY[side] * COUNTS);
}

static void motors_off(void)
{
    rc_motor_set(0, 0.0);
    rc_motor_standby(1);
    balancing = 0;
    calm = 0;
}

/* Both motors get the same voltage, as far as the battery has it. */
static void drive(double volts)
{
    double duty = 1000 * volts / battery;
    duty = duty > 1 ? 1 : duty < -1 ? -1 : duty;
    for (int side = 0; side < 2; side++)
        rc_motor_set(MOTOR_CHANNEL[side], MOTOR_POLARITY[side] * duty);
}

/* True once the robot rested near upright for long enough. */
static int at_rest(double gyro, double wheels, double tilt)
{
    const double turned = wheels - wheels_at_rest;
    if (calm == 0 || !(tilt > -REST_TILT && tilt < REST_TILT)
        || !(gyro > -REST_GYRO && gyro < REST_GYRO)
        || !(turned > -REST_TURN && turned < REST_TURN)) {
        wheels_at_rest = wheels;
        gyro_sum = tilt_sum = 0;
        calm = 1;
        return 0;
    }
    gyro_sum += gyro;
    tilt_sum += tilt;
    return calm++ == REST_TICKS;
}

/* Called by the IMU at RATE_HZ. */
static void tick(void)
{
    const double gyro = read_gyro();
    const double tilt = read_tilt();
    const double wheels = (read_wheel(0) + read_wheel(1)) / 2;

    ticks++;
    if (rc_get_state() != RUNNING) {
        if (balancing)
            motors_off();
        calm = 0;
    } else if (balancing) {
        const double volts = (double)${name}_step(&robot,
            ($real)gyro, ($real)wheels, ($real)tilt, 0, 0);
        if (robot.fault == ${NAME}_RUNNING) {
            drive(volts);
        } else {
            reason = robot.fault;
            rc_set_state(PAUSED);
            motors_off();
        }
    } else if (at_rest(gyro, wheels, tilt)) {
        ${name}_start(&robot, ($real)(tilt_sum / REST_TICKS),
            ($real)wheels, ($real)(gyro_sum / REST_TICKS));
        rc_motor_set(0, 0.0);
        rc_motor_standby(0);
        balancing = 1;
        reason = 0;
    }
}

/* Pause and wait for rest in turns; a long press ends the program. */
static void pause_pressed(void)
{
    if (rc_get_state() == RUNNING)
        rc_set_state(PAUSED);
    else if (rc_get_state() == PAUSED)
        rc_set_state(RUNNING);
    for (int i = 0; i < 100; i++) {
        rc_usleep(20000);
        if (rc_button_get_state(RC_BTN_PIN_PAUSE) == RC_BTN_STATE_RELEASED)
            return;
    }
    rc_set_state(EXITING);
}

static void measure_battery(void)
{
    const double volts = rc_adc_batt();
    const int sane = volts > V_LOW && volts < V_HIGH;
    battery = (int)(1000 * (sane ? volts : V_NOMINAL));
}

/* Look after everything slow until the program ends. */
static void watch(int checking)
{
    int told = 0, silent = 0;
    unsigned seen = ticks;
    while (rc_get_state() != EXITING) {
        rc_usleep(50000);
        measure_battery();
        rc_led_set(RC_LED_GREEN, rc_get_state() == RUNNING);
        rc_led_set(RC_LED_RED, rc_get_state() != RUNNING);
        if (checking)
            printf("tilt %6.3f rad, gyro %6.2f rad/s, wheels %7.2f and "
                   "%7.2f rad\n", read_tilt(), read_gyro(),
                   read_wheel(0), read_wheel(1));
        if (reason != told && rc_get_state() == PAUSED) {
            printf("motors off: %s\n", REASON[reason]);
            fflush(stdout);
        }
        told = rc_get_state() == PAUSED ? reason : 0;
        silent = ticks == seen ? silent + 1 : 0;
        seen = ticks;
        if (silent == 5) {
            rc_motor_standby(1);
            rc_set_state(EXITING);
            fprintf(stderr, "the IMU went silent\n");
        }
    }
}

static int fail(const char *part)
{
    fprintf(stderr, "can't start the %s\n", part);
    return -1;
}

int main(int argc, char *argv[])
{
    (void)argv;
    const int checking = argc > 1;
    rc_mpu_config_t config = rc_mpu_default_config();
    config.dmp_sample_rate = RATE_HZ;
    config.dmp_fetch_accel_gyro = 1;
    config.orient = ORIENTATION_Y_UP;

    if (rc_kill_existing_process(2.0f) < -2)
        return fail("program: another one runs");
    if (rc_enable_signal_handler())
        return fail("signal handler");
    if (rc_motor_init())
        return fail("motors");
    rc_motor_standby(1);
    if (rc_encoder_eqep_init())
        return fail("encoders");
    if (rc_button_init(RC_BTN_PIN_PAUSE, RC_BTN_POLARITY_NORM_HIGH,
                       RC_BTN_DEBOUNCE_DEFAULT_US))
        return fail("PAUSE button");
    if (!checking)
        rc_button_set_callbacks(RC_BTN_PIN_PAUSE, pause_pressed, NULL);
    if (rc_adc_init())
        fprintf(stderr, "no ADC: taking %.1f V for granted\n", V_NOMINAL);
    measure_battery();
    if (rc_mpu_initialize_dmp(&imu, config))
        return fail("IMU");
    rc_make_pid_file();
    rc_set_state(checking ? PAUSED : RUNNING);
    rc_mpu_set_dmp_callback(tick);
    watch(checking);

    rc_mpu_power_off();
    motors_off();
    rc_motor_cleanup();
    rc_encoder_eqep_cleanup();
    rc_adc_cleanup();
    rc_button_cleanup();
    rc_led_set(RC_LED_GREEN, 0);
    rc_led_set(RC_LED_RED, 0);
    rc_led_cleanup();
    rc_remove_pid_file();
    return 0;
}
