/* rc_robot.h: what both programs of a BeagleBone Blue robot share
 *
 * (Where this comes from.)
 *
 * Its pins and its battery, and how librobotcontrol begins and ends.
 */
#ifndef RC_ROBOT_H
#define RC_ROBOT_H
#include <stdint.h>
#include <stdio.h>
#include <robotcontrol.h>

#define RATE_HZ 100

#define V_NOMINAL 7.4 /* V, where the battery isn't measured */
#define V_LOW 5.0 /* V; a battery below isn't measured */
#define V_HIGH 9.0 /* V; nor one above */

/* Left and right. */
static const int MOTOR_CHANNEL[2] = {3, 2};
static const int MOTOR_POLARITY[2] = {1, -1};
static const int ENCODER_CHANNEL[2] = {3, 2};
static const int ENCODER_POLARITY[2] = {1, -1};

static const double TURN = 6.283185307179586; /* rad */

static rc_mpu_data_t imu;
static volatile unsigned ticks;
static volatile int battery = (int)(1000 * V_NOMINAL); /* mV: an int is atomic */

/* The left motor (1), the right one (2) or both (0) get the same voltage, as far as the
 * battery has it: this one. */
static inline double drive_some(double volts, int alone)
{
    double duty = 1000 * volts / battery;
    duty = duty > 1 ? 1 : duty < -1 ? -1 : duty;
    for (int side = 0; side < 2; side++)
        rc_motor_set(MOTOR_CHANNEL[side],
                     alone == 2 - side ? 0 : MOTOR_POLARITY[side] * duty);
    return duty * battery / 1000;
}

static inline double drive_both(double volts)
{
    return drive_some(volts, 0);
}

static void measure_battery(void)
{
    const double volts = rc_adc_batt();
    const int sane = volts > V_LOW && volts < V_HIGH;
    battery = (int)(1000 * (sane ? volts : V_NOMINAL));
}

/* An IMU that says nothing for a quarter of a second ends the program. */
static void watch_imu(void)
{
    static unsigned seen;
    static int silent; /* rounds of 50 ms */
    silent = ticks == seen ? silent + 1 : 0;
    seen = ticks;
    if (silent == 5) {
        rc_motor_standby(1);
        rc_set_state(EXITING);
        fprintf(stderr, "the IMU went silent\n");
    }
}

static int fail(const char *part)
{
    fprintf(stderr, "can't start the %s\n", part);
    return -1;
}

/* All parts but the IMU; zero if they start. */
static int begin(void (*pause_pressed)(void))
{
    if (rc_kill_existing_process(2.0f) < -2)
        return fail("program: another one runs");
    if (!rc_mpu_is_gyro_calibrated())
        fprintf(stderr, "the gyro isn't calibrated: run rc_calibrate_gyro\n");
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
    if (pause_pressed)
        rc_button_set_callbacks(RC_BTN_PIN_PAUSE, pause_pressed, NULL);
    if (rc_adc_init())
        fprintf(stderr, "no ADC: taking %.1f V for granted\n", V_NOMINAL);
    measure_battery();
    return 0;
}

/* The IMU, which calls tick at RATE_HZ from now on; zero if it starts. */
static int begin_ticks(void (*tick)(void), rc_state_t state)
{
    rc_mpu_config_t config = rc_mpu_default_config();
    config.dmp_sample_rate = RATE_HZ;
    config.dmp_fetch_accel_gyro = 1;
    config.orient = ORIENTATION_Y_UP;
    if (rc_mpu_initialize_dmp(&imu, config))
        return fail("IMU");
    rc_make_pid_file();
    rc_set_state(state);
    rc_mpu_set_dmp_callback(tick);
    return 0;
}

static void end(void)
{
    rc_motor_cleanup();
    rc_encoder_eqep_cleanup();
    rc_adc_cleanup();
    rc_button_cleanup();
    rc_remove_pid_file();
}

#endif
