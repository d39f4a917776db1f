/* rc_identify.c: record the log of an experiment with librobotcontrol
 *
 * (Where this comes from.)
 *
 * Build on the robot:
 *   gcc -std=gnu99 -O2 rc_identify.c -o rc_identify -lrobotcontrol \
 *       -lm -pthread
 *
 * Run, with PAUSE at hand:
 *   rc_identify body body.csv      the robot is held by its wheels, upside
 *                                  down, and its body hangs at rest
 *   rc_identify wheels wheels.csv  it lies on its back, wheels in the air
 *
 * Motors get a sine that sweeps up and down. In each row of the file the
 * sensors were read before the row's V began to act.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <robotcontrol.h>

#define RATE_HZ 100
#define AMPLITUDE 1.85 /* V, of the sine */
#define SECONDS 30.0 /* s, of the sweep, either way */
#define ROWS 6000

/* The robot's description. */
#define V_NOMINAL 7.4 /* V, where the battery isn't measured */
#define V_LOW 5.0 /* V; a battery below isn't measured */
#define V_HIGH 9.0 /* V; nor one above */

/* Left and right. */
static const int MOTOR_CHANNEL[2] = {3, 2};
static const int MOTOR_POLARITY[2] = {1, -1};
static const int ENCODER_CHANNEL[2] = {3, 2};
static const int ENCODER_POLARITY[2] = {1, -1};

static const double TURN = 6.283185307179586; /* rad */
static const double BODY[2] = {1.1, 21.0}; /* Hz, the sweep's ends */
static const double WHEELS[2] = {0.3, 30.0}; /* Hz */

static struct {
    double t, V, gyro;
    int encoder[2];
} row[ROWS];

static rc_mpu_data_t imu;
static const double *sweep;
static double turns;          /* of the sine, so far */
static uint64_t first;        /* ns, of the first row */
static volatile int rows;
static volatile unsigned ticks;
static volatile int battery = (int)(1000 * V_NOMINAL); /* mV */

/* The volts that the motors got. */
static double drive(double volts)
{
    double duty = 1000 * volts / battery;
    duty = duty > 1 ? 1 : duty < -1 ? -1 : duty;
    for (int side = 0; side < 2; side++)
        rc_motor_set(MOTOR_CHANNEL[side], MOTOR_POLARITY[side] * duty);
    return duty * battery / 1000;
}

/* The sine's next value; its frequency goes up and comes back. */
static double chirp(double t)
{
    const double s = t < SECONDS ? t : 2 * SECONDS - t;
    const double volts = AMPLITUDE * sin(TURN * turns);
    turns += (sweep[0] + (sweep[1] - sweep[0]) * s / SECONDS) / RATE_HZ;
    turns -= floor(turns);
    return volts;
}

/* Called by the IMU at RATE_HZ. */
static void tick(void)
{
    const uint64_t now = rc_nanos_since_boot();
    const int n = rows;

    ticks++;
    if (rc_get_state() != RUNNING || n == ROWS) {
        drive(0);
        return;
    }
    if (n == 0)
        first = now;
    row[n].t = (double)(now - first) * 1e-9;
    row[n].gyro = imu.gyro[0] * DEG_TO_RAD;
    for (int side = 0; side < 2; side++)
        row[n].encoder[side] = ENCODER_POLARITY[side]
            * rc_encoder_eqep_read(ENCODER_CHANNEL[side]);
    row[n].V = drive(chirp((double)n / RATE_HZ));
    rows = n + 1;
}

static void pause_pressed(void)
{
    rc_set_state(EXITING);
}

static void measure_battery(void)
{
    const double volts = rc_adc_batt();
    const int sane = volts > V_LOW && volts < V_HIGH;
    battery = (int)(1000 * (sane ? volts : V_NOMINAL));
}

static int save(const char *path, int body)
{
    FILE *file = fopen(path, "w");
    if (file == NULL)
        return -1;
    fputs(body ? "t,V,gyro\n" : "t,V,encoder1,encoder2\n", file);
    for (int n = 0; n < rows; n++) {
        fprintf(file, "%.6f,%.5f,", row[n].t, row[n].V);
        if (body)
            fprintf(file, "%.6g\n", row[n].gyro);
        else
            fprintf(file, "%d,%d\n", row[n].encoder[0], row[n].encoder[1]);
    }
    return fclose(file);
}

static int fail(const char *part)
{
    fprintf(stderr, "can't start the %s\n", part);
    return -1;
}

int main(int argc, char *argv[])
{
    const int body = argc == 3 && strcmp(argv[1], "body") == 0;
    if (!body && !(argc == 3 && strcmp(argv[1], "wheels") == 0)) {
        fprintf(stderr, "say: rc_identify body|wheels file.csv\n");
        return -1;
    }
    sweep = body ? BODY : WHEELS;
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
    if (rc_encoder_eqep_init())
        return fail("encoders");
    if (rc_button_init(RC_BTN_PIN_PAUSE, RC_BTN_POLARITY_NORM_HIGH,
                       RC_BTN_DEBOUNCE_DEFAULT_US))
        return fail("PAUSE button");
    rc_button_set_callbacks(RC_BTN_PIN_PAUSE, pause_pressed, NULL);
    if (rc_adc_init())
        fprintf(stderr, "no ADC: taking %.1f V for granted\n", V_NOMINAL);
    measure_battery();
    if (rc_mpu_initialize_dmp(&imu, config))
        return fail("IMU");
    rc_make_pid_file();
    rc_motor_standby(0);
    rc_set_state(RUNNING);
    rc_mpu_set_dmp_callback(tick);

    unsigned seen = ticks;
    int silent = 0;
    while (rc_get_state() != EXITING && rows < ROWS) {
        rc_usleep(50000);
        measure_battery();
        silent = ticks == seen ? silent + 1 : 0;
        seen = ticks;
        if (silent == 5) {
            fprintf(stderr, "the IMU went silent\n");
            rc_set_state(EXITING);
        }
    }
    rc_set_state(EXITING);
    rc_mpu_power_off();
    rc_motor_set(0, 0.0);
    rc_motor_standby(1);
    rc_motor_cleanup();
    rc_encoder_eqep_cleanup();
    rc_adc_cleanup();
    rc_button_cleanup();
    rc_remove_pid_file();
    if (save(argv[2], body)) {
        fprintf(stderr, "can't write %s\n", argv[2]);
        return -1;
    }
    printf("wrote %d rows of %s\n", rows, argv[2]);
    return rows == ROWS ? 0 : 1;
}
