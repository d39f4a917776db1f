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
#include <string.h>
#include "rc_robot.h"

#define SECONDS 30.0 /* s, of the sweep, either way */
#define ROWS 6000

/* The sweep's ends in Hz, and the sine's amplitude in V. */
static const double BODY[3] = {1.1, 21.0, 1.85};
static const double WHEELS[3] = {0.3, 30.0, 5.92};
/* Of that, what a motor gets that drives the body alone, on the sweep's way back. */
static const double ALONE = 2.0;

static struct {
    double t, V, gyro;
    int encoder[2], alone;
} row[ROWS];

static const double *sweep;
static double turns;          /* of the sine, so far */
static uint64_t first;        /* ns, of the first row */
static volatile int rows;

/* The sine's next value; its frequency goes up and comes back. */
static double chirp(double t)
{
    const double s = t < SECONDS ? t : 2 * SECONDS - t;
    const double volts = sweep[2] * sin(TURN * turns);
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
        drive_both(0);
        return;
    }
    if (n == 0)
        first = now;
    row[n].t = (double)(now - first) * 1e-9;
    row[n].gyro = imu.gyro[0] * DEG_TO_RAD;
    for (int side = 0; side < 2; side++)
        row[n].encoder[side] = ENCODER_POLARITY[side]
            * rc_encoder_eqep_read(ENCODER_CHANNEL[side]);
    const double t = (double)n / RATE_HZ, volts = chirp(t);
    const int alone = sweep == BODY && t >= SECONDS ? 1 + (int)t % 2 : 0;
    row[n].alone = alone;
    row[n].V = alone ? drive_some(ALONE * volts, alone) / 2 : drive_both(volts);
    rows = n + 1;
}

static void pause_pressed(void)
{
    rc_set_state(EXITING);
}

static int save(const char *path, int body)
{
    FILE *file = fopen(path, "w");
    if (file == NULL)
        return -1;
    fputs(body ? "t,V,gyro,alone\n" : "t,V,encoder1,encoder2\n", file);
    for (int n = 0; n < rows; n++) {
        fprintf(file, "%.6f,%.5f,", row[n].t, row[n].V);
        if (body)
            fprintf(file, "%.6g,%d\n", row[n].gyro, row[n].alone);
        else
            fprintf(file, "%d,%d\n", row[n].encoder[0], row[n].encoder[1]);
    }
    return fclose(file);
}

int main(int argc, char *argv[])
{
    const int body = argc == 3 && strcmp(argv[1], "body") == 0;
    if (!body && !(argc == 3 && strcmp(argv[1], "wheels") == 0)) {
        fprintf(stderr, "say: rc_identify body|wheels file.csv\n");
        return -1;
    }
    sweep = body ? BODY : WHEELS;
    if (begin(pause_pressed))
        return -1;
    rc_motor_standby(0);
    if (begin_ticks(tick, RUNNING))
        return -1;

    while (rc_get_state() != EXITING && rows < ROWS) {
        rc_usleep(50000);
        measure_battery();
        watch_imu();
    }
    rc_set_state(EXITING);
    rc_mpu_power_off();
    rc_motor_set(0, 0.0);
    rc_motor_standby(1);
    end();
    if (save(argv[2], body)) {
        fprintf(stderr, "can't write %s\n", argv[2]);
        return -1;
    }
    printf("wrote %d rows of %s\n", rows, argv[2]);
    return rows == ROWS ? 0 : 1;
}
