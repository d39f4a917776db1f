/* rc_balance.c: balance a BeagleBone Blue robot with librobotcontrol
 *
 * (Where this comes from.)
 *
 * Build on the robot, with balance_steer.c where BALANCE_STEERS is 1:
 *   gcc -std=gnu99 -O2 -ffp-contract=off rc_balance.c balance_run.c \
 *       balance.c -o rc_balance -lrobotcontrol -lm -pthread
 *
 * FIRST check the signs on a stand, wheels in the air, PAUSE at hand:
 *   1. "rc_balance check" prints what the sensors say, motors off. Tip
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
 *
 *   rc_balance log.csv            also writes a row a tick into log.csv,
 *                                   which sosbook.pendulum's compare reads
 *   rc_balance log.csv speed.txt  also obeys the number in speed.txt, the
 *                                   wheels' speed in rad/s: echo 2 > speed.txt
 *   rc_balance log.csv -          obeys lines that come in: v 2, or p 30 to
 *                                   go where the wheels have rolled 30 rad
 *                                   since the start, and stay
 *   rc_balance log.csv dsm        obeys a DSM radio's sticks
 *
 * Where BALANCE_STEERS is 1 a second number, in the file or in the line, is the turn
 * rate in rad/s, positive to the left: v 2 0.5. Without one the robot keeps
 * its heading. Of p it is the heading in rad, to the left of the start's.
 *
 * A second without a command, a readable file or the radio stops the wheels.
 */
#include <math.h>
#include <poll.h>
#include <string.h>
#include <unistd.h>
#include "rc_robot.h"
#include "balance_run.h"

typedef balance_real real; /* what the law computes with */

/* The robot's description. */
#define BOARD_MOUNT_ANGLE 0.49 /* rad, of the board in the body */
#define COUNTS 2122.2 /* of an encoder, per turn of a wheel */

#define SILENCE 1000 /* ms without a command */

/* Sticks of a DSM radio: forward is positive, and so is left. */
#define DSM_SPEED 3 /* channel */
#define DSM_SPEED_POLARITY 1
#define DSM_TURN 2 /* channel */
#define DSM_TURN_POLARITY 1
#define DSM_DEAD 0.04 /* of the stick's full way */

static const char *const REASON[] = {"running", "sensor", "fall", "stall", "command",
    "late"};

/* The callback alone writes these. */
static balance_run run;
static volatile int reason; /* the last fault */
static uint64_t last; /* ns, when the last tick was */

/* The main loop alone writes these, in mrad/s and ms, for an int is atomic. */
static volatile int wanted;
static volatile int going, place; /* numbers of a place to go to; the way, mrad */
static volatile unsigned heard; /* when the last command came */
static volatile int wanted_turn, bearing; /* mrad to the left of the start */

/* The ticks, from the callback to a thread that waits for the card. */
#define LOG_ROWS 1024
static struct {
    double t, gyro, wheels, tilt, target, rate, volts, theta, battery;
    double left, right, V_left, V_right, heading;
    int fault;
    long late;
} row[LOG_ROWS];
static volatile unsigned logged, saved;
static int logging;

static double cut(double value, double bound)
{
    return value > bound ? bound : value < -bound ? -bound : value;
}

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
    balance_run_stop(&run);
}

/* Each motor its volts, as far as the battery has them. */
static void drive(void)
{
    const real most = (real)(battery / 1000.0);
    real volts[2];
    balance_run_volts(&run, most, volts);
    for (int side = 0; side < 2; side++)
        rc_motor_set(MOTOR_CHANNEL[side],
            MOTOR_POLARITY[side] * (double)(volts[side] / most));
}

/* Remember a tick; a row that finds no room is lost. */
static void note(double gyro, double left, double right, double tilt, int fault)
{
    const unsigned n = logged % LOG_ROWS;
    if (!logging || logged - saved == LOG_ROWS)
        return;
    row[n].t = (double)rc_nanos_since_boot() * 1e-9;
    row[n].gyro = gyro;
    row[n].wheels = (left + right) / 2;
    row[n].tilt = tilt;
    row[n].target = (double)run.target;
    row[n].rate = (double)run.rate;
    row[n].volts = (double)run.volts;
    row[n].theta = (double)run.theta;
    row[n].battery = battery / 1000.0;
    row[n].left = left;
    row[n].right = right;
    row[n].V_left = (double)run.motor[0];
    row[n].V_right = (double)run.motor[1];
    row[n].heading = (double)run.heading;
    row[n].fault = fault;
    row[n].late = run.late;
    logged++;
}

static unsigned milliseconds(void)
{
    return (unsigned)(rc_nanos_since_boot() / 1000000);
}

/* Called by the IMU at RATE_HZ. */
static void tick(void)
{
    const double gyro = read_gyro(), tilt = read_tilt();
    const double left = read_wheel(0), right = read_wheel(1);
    const uint64_t now = rc_nanos_since_boot();
    const double elapsed = (double)(now - last) * 1e-9;
    const int obeys = milliseconds() - heard <= SILENCE;

    last = now;
    ticks++;
    if (rc_get_state() != RUNNING) {
        if (run.balancing)
            motors_off();
        balance_run_stop(&run);
        return;
    }
    run.speed = (real)(obeys * wanted / 1000.0);
    run.turn = (real)(obeys * wanted_turn / 1000.0);
    run.place = (real)(place / 1000.0);
    run.bearing = (real)(bearing / 1000.0);
    run.going = going;
    const int done = balance_run_tick(&run, (real)gyro, (real)left, (real)right,
        (real)tilt, (real)elapsed);
    if (done == BALANCE_STARTED) {
        note((double)run.bias, left, right, (double)run.theta, -1);
        rc_motor_set(0, 0.0);
        rc_motor_standby(0);
        going = 0;
        reason = 0;
    }
    if (done != BALANCE_BALANCED)
        return;
    note(gyro, left, right, tilt, run.fault);
    if (run.fault == BALANCE_RUNNING) {
        drive();
    } else {
        reason = run.fault;
        rc_set_state(PAUSED);
        motors_off();
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

/* Take a command. */
static void want(double speed, double turn)
{
    if (!(fabs(speed) <= 1e6 && fabs(turn) <= 1e6))
        return;
    going = 0;
    wanted = (int)(1000 * cut(speed, 1e3));
    wanted_turn = (int)(1000 * cut(turn, 1e3));
    heard = milliseconds();
}

/* Take a place: one number, the way, or two of them, with the heading. */
static void go(int numbers, double way, double turn)
{
    if (!(fabs(way) <= 1e6 && fabs(turn) <= 1e6))
        return;
    going = 0;
    place = (int)(1000 * way);
    bearing = (int)(1000 * turn);
    going = numbers;
}

/* The numbers in a file. */
static void obey_file(const char *path)
{
    FILE *file = fopen(path, "r");
    double speed = 0, turn = 0;
    if (file == NULL)
        return;
    if (fscanf(file, "%lf %lf", &speed, &turn) >= 1)
        want(speed, turn);
    fclose(file);
}

/* Lines of standard input: v or p and the numbers. */
static void obey_lines(void)
{
    static char line[64];
    static size_t length;
    struct pollfd input = {0, POLLIN, 0};
    char letter;
    while (poll(&input, 1, 0) > 0 && read(0, &letter, 1) == 1) {
        double way = 0, turn = 0;
        if (letter != '\n') {
            line[length] = letter;
            length += length < sizeof line - 1;
            continue;
        }
        line[length] = 0;
        const int numbers = sscanf(line + (length > 0), "%lf %lf", &way, &turn);
        if (line[0] == 'v' && numbers >= 1)
            want(way, turn);
        if (line[0] == 'p' && numbers >= 1)
            go(numbers, way, turn);
        length = 0;
    }
}

/* A stick between -1 and 1; near its middle it is zero. */
static double stick(int channel, int polarity)
{
    const double way = polarity * rc_dsm_ch_normalized(channel);
    return way > DSM_DEAD || way < -DSM_DEAD ? way : 0;
}

static void obey_radio(void)
{
    if (rc_dsm_is_new_data())
        want((double)BALANCE_SPEED * stick(DSM_SPEED, DSM_SPEED_POLARITY),
            (double)BALANCE_TURN_RATE * stick(DSM_TURN, DSM_TURN_POLARITY));
}

static void obey(const char *source)
{
    if (strcmp(source, "-") == 0)
        obey_lines();
    else if (strcmp(source, "dsm") == 0)
        obey_radio();
    else
        obey_file(source);
}

/* Write the ticks that the callback has left. */
static void save(FILE *file)
{
    for (; saved != logged; saved++) {
        const unsigned n = saved % LOG_ROWS;
        fprintf(file, "%.6f,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,"
                "%.4g,%d,%ld", row[n].t, row[n].gyro, row[n].wheels,
                row[n].tilt, row[n].target, row[n].rate, row[n].volts,
                row[n].theta, row[n].battery, row[n].fault, row[n].late);
#if BALANCE_STEERS
        fprintf(file, ",%.17g,%.17g,%.17g,%.17g,%.17g", row[n].left,
                row[n].right, row[n].V_left, row[n].V_right, row[n].heading);
#endif
        fputs("\n", file);
    }
    fflush(file);
}

/* A thread of its own: nothing but the log waits for a card that is slow. */
static void *keep(void *file)
{
    while (rc_get_state() != EXITING) {
        rc_usleep(50000);
        save(file);
    }
    save(file);
    return NULL;
}

/* Look after commands, the IMU, the battery and the lights until the end. */
static void watch(int checking, const char *source)
{
    int told = 0, waited = 0;
    while (rc_get_state() != EXITING) {
        rc_usleep(50000);
        measure_battery();
        if (source)
            obey(source);
        waited = rc_get_state() == RUNNING && !run.balancing ? waited + 1 : 0;
        if (waited % 60 == 59 && run.waiting && run.waiting[0]) {
            printf("waiting: %s\n", run.waiting);
            fflush(stdout);
        }
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
        watch_imu();
    }
}

int main(int argc, char *argv[])
{
    const int checking = argc > 1 && strcmp(argv[1], "check") == 0;
    const int radio = argc > 2 && strcmp(argv[2], "dsm") == 0;
    FILE *file = NULL;
    pthread_t keeper;

    if (argc > 1 && !checking) {
        file = fopen(argv[1], "w");
        if (file == NULL)
            return fail("log");
        fputs("t,gyro,wheels,tilt,target,rate,V,theta,battery,fault,late", file);
#if BALANCE_STEERS
        fputs(",left,right,V_left,V_right,heading", file);
#endif
        fputs("\n", file);
        logging = 1;
    }
    if (begin(checking ? NULL : pause_pressed))
        return -1;
    if (radio && rc_dsm_init())
        return fail("DSM radio");
    if (begin_ticks(tick, checking ? PAUSED : RUNNING))
        return -1;
    if (file && rc_pthread_create(&keeper, keep, file, SCHED_OTHER, 0))
        return fail("log");
    watch(checking, argc > 2 ? argv[2] : NULL);

    rc_mpu_power_off();
    motors_off();
    if (file && rc_pthread_timed_join(keeper, NULL, 3.0f) == 0)
        fclose(file);
    if (radio)
        rc_dsm_cleanup();
    rc_led_set(RC_LED_GREEN, 0);
    rc_led_set(RC_LED_RED, 0);
    rc_led_cleanup();
    end();
    return 0;
}
