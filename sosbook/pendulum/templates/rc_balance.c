/* rc_balance.c: balance a BeagleBone Blue robot with librobotcontrol
 *
 * (Where this comes from.)
 *
 * Build on the robot, without balance_steer.c where STEERS is 0:
 *   gcc -std=gnu99 -O2 -ffp-contract=off rc_balance.c balance.c \
 *       balance_steer.c -o rc_balance -lrobotcontrol -lm -pthread
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
 *                                   which sosbook.mip's compare reads
 *   rc_balance log.csv speed.txt  also obeys the number in speed.txt, the
 *                                   wheels' speed in rad/s: echo 2 > speed.txt
 *   rc_balance log.csv -          obeys lines that come in: v 2, or p 30 to
 *                                   go where the wheels have rolled 30 rad
 *                                   since the start, and stay
 *   rc_balance log.csv dsm        obeys a DSM radio's sticks
 *
 * Where STEERS is 1 a second number, in the file or in the line, is the turn
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
#include "balance.h"

#define STEERS 1 /* 1: a heading is held; 0: both motors get the same */
#if STEERS
#include "balance_steer.h"
#endif

typedef balance_real real; /* what the law computes with */

/* The robot's description. */
#define BOARD_MOUNT_ANGLE 0.49 /* rad, of the board in the body */
#define COUNTS 2122.2 /* of an encoder, per turn of a wheel */

/* A set point that moves. */
#define SPEED 0.0 /* rad/s, at most */
#define ACCELERATION 0.0 /* rad/s^2 */
#define TURN_RATE 0.0 /* rad/s of the heading, at most */
#define TURN_ACCELERATION 0.0 /* rad/s^2 */
#define GENTLE 0.3 /* of these, on the way to a place: it is hardly passed */
#define PER_RADIAN 2.5 /* rad right less left, per rad */
#define SILENCE 1000 /* ms without a command */
#define JITTER 0.0005 /* s, by which a tick may come late */
#define LATE 0 /* more late ticks than others; 0: any */

/* Sticks of a DSM radio: forward is positive, and so is left. */
#define DSM_SPEED 3 /* channel */
#define DSM_SPEED_POLARITY 1
#define DSM_TURN 2 /* channel */
#define DSM_TURN_POLARITY 1
#define DSM_DEAD 0.04 /* of the stick's full way */

/* At rest near upright: all readings of a second lie within. */
#define REST_TICKS RATE_HZ
#define REST_TILT 0.2  /* rad */
#define REST_GYRO 0.1  /* rad/s */
#define REST_TURN 0.05 /* rad, of the wheels */

static const char *const REASON[] = {"running", "sensor", "fall", "stall", "command",
    "late"};

/* The callback alone writes these. */
static balance_state robot;
static int balancing;
static int calm;            /* ticks at rest so far */
static double gyro_sum, tilt_sum, wheels_at_rest;
static double target, rate; /* set points of phi and phi' */
#if STEERS
static double heading, turn_rate; /* rad and rad/s, set points */
static balance_steering steering;
static double wheel[2]; /* rad, left and right */
static real motor[2]; /* V, left and right */
#endif
static const char *why_waiting = ""; /* for a robot that doesn't start */
static volatile int reason; /* the last fault */
static uint64_t last; /* ns, when the last tick was */
static int late, overdue; /* ticks: all of them, and less the others */

/* The main loop alone writes these, in mrad/s and ms, for an int is atomic. */
static volatile int wanted;
static volatile int going, place; /* numbers of a place to go to; the way, mrad */
static volatile unsigned heard; /* when the last command came */
#if STEERS
static volatile int wanted_turn, bearing; /* mrad to the left of the start */
#endif

/* The ticks, from the callback to a thread that waits for the card. */
#define LOG_ROWS 1024
static struct {
    double t, gyro, wheels, tilt, target, rate, volts, theta, battery;
#if STEERS
    double left, right, V_left, V_right, heading;
#endif
    int fault, late;
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
    balancing = 0;
    calm = 0;
}

#if STEERS
/* Each motor its volts; with a battery that hasn't them, balance is first. */
static void drive(const real volts[2])
{
    const double most = battery / 1000.0;
    const double left = (double)volts[0], right = (double)volts[1];
    const double mean = cut((left + right) / 2, most);
    const double half = cut((right - left) / 2, most - (mean < 0 ? -mean : mean));
    rc_motor_set(MOTOR_CHANNEL[0], MOTOR_POLARITY[0] * (mean - half) / most);
    rc_motor_set(MOTOR_CHANNEL[1], MOTOR_POLARITY[1] * (mean + half) / most);
}
#endif

/* True once the robot rested near upright for long enough. */
static int at_rest(double gyro, double wheels, double tilt)
{
    const double turned = wheels - wheels_at_rest;
    if (calm == 0 || !(tilt > -REST_TILT && tilt < REST_TILT)
        || !(gyro > -REST_GYRO && gyro < REST_GYRO)
        || !(turned > -REST_TURN && turned < REST_TURN)) {
        why_waiting = !(tilt > -REST_TILT && tilt < REST_TILT) ?
            "hold it upright" : !(gyro > -REST_GYRO && gyro < REST_GYRO) ?
            "hold it still: the gyro turns, or isn't calibrated" :
            calm > 0 ? "hold its wheels still" : "";
        wheels_at_rest = wheels;
        gyro_sum = tilt_sum = 0;
        calm = 1;
        return 0;
    }
    gyro_sum += gyro;
    tilt_sum += tilt;
    return calm++ == REST_TICKS;
}

/* Remember a tick; a row that finds no room is lost. */
static void note(double gyro, double wheels, double tilt, double volts,
    int fault)
{
    const unsigned n = logged % LOG_ROWS;
    if (!logging || logged - saved == LOG_ROWS)
        return;
    row[n].t = (double)rc_nanos_since_boot() * 1e-9;
    row[n].gyro = gyro;
    row[n].wheels = wheels;
    row[n].tilt = tilt;
    row[n].target = target;
    row[n].rate = rate;
    row[n].volts = volts;
    row[n].theta = (double)robot.theta;
    row[n].battery = battery / 1000.0;
#if STEERS
    row[n].left = wheel[0];
    row[n].right = wheel[1];
    row[n].V_left = (double)motor[0];
    row[n].V_right = (double)motor[1];
    row[n].heading = heading;
#endif
    row[n].fault = fault;
    row[n].late = late;
    logged++;
}

static unsigned milliseconds(void)
{
    return (unsigned)(rc_nanos_since_boot() / 1000000);
}

/* A tick that comes late makes phi' wrong, and with it the law. */
static void mind(uint64_t now)
{
    const double by = (double)(now - last) * 1e-9 - 1.0 / RATE_HZ;
    if (by > JITTER) {
        late++;
        overdue += 1 + (int)cut(by * RATE_HZ, RATE_HZ);
    } else if (overdue > 0) {
        overdue--;
    }
    if (LATE > 0 && overdue > LATE)
        robot.fault = BALANCE_LATE;
}

/* The speed from which it stops just when nothing is left. */
static double stopping(double left, double most, double acceleration)
{
    const double way = fabs(left), step = acceleration / RATE_HZ;
    const double speed = sqrt(step * step / 4 + 2 * acceleration * way) - step / 2;
    return cut(left * RATE_HZ, speed < most ? speed : most);
}

/* Move the set points towards what is wanted, or to rest where nobody says more. */
static void ramp(void)
{
    const int obeys = milliseconds() - heard <= SILENCE, to = going;
    const double share = to ? GENTLE : 1, speed = to ?
        stopping(place / 1000.0 - target, SPEED, share * ACCELERATION) :
        obeys * wanted / 1000.0;
    rate += cut(speed - rate, share * ACCELERATION / RATE_HZ);
    target += rate / RATE_HZ;
#if STEERS
    const double turn = to == 1 ? 0 : to ?
        stopping(bearing / 1000.0 - heading, share * TURN_RATE,
            share * TURN_ACCELERATION) :
        obeys * wanted_turn / 1000.0;
    turn_rate += cut(turn - turn_rate, share * TURN_ACCELERATION / RATE_HZ);
    heading += turn_rate / RATE_HZ;
#endif
}

/* Called by the IMU at RATE_HZ. */
static void tick(void)
{
    const double gyro = read_gyro();
    const double tilt = read_tilt();
#if STEERS
    wheel[0] = read_wheel(0);
    wheel[1] = read_wheel(1);
    const double wheels = (wheel[0] + wheel[1]) / 2;
#else
    const double wheels = (read_wheel(0) + read_wheel(1)) / 2;
#endif

    const uint64_t now = rc_nanos_since_boot();
    ticks++;
    if (rc_get_state() != RUNNING) {
        if (balancing)
            motors_off();
        calm = 0;
    } else if (balancing) {
        mind(now);
        ramp();
        const double volts = (double)balance_step(&robot, (real)gyro,
            (real)wheels, (real)tilt, (real)target, (real)rate);
#if STEERS
        balance_steer(&steering, &robot, (real)wheel[0], (real)wheel[1],
            (real)(PER_RADIAN * heading), (real)(PER_RADIAN * turn_rate),
            motor);
#endif
        note(gyro, wheels, tilt, volts, robot.fault);
        if (robot.fault == BALANCE_RUNNING) {
#if STEERS
            drive(motor);
#else
            drive_both(volts);
#endif
        } else {
            reason = robot.fault;
            rc_set_state(PAUSED);
            motors_off();
        }
    } else if (at_rest(gyro, wheels, tilt)) {
        balance_start(&robot, (real)(tilt_sum / REST_TICKS),
            (real)wheels, (real)(gyro_sum / REST_TICKS));
        target = rate = 0;
        going = 0;
        late = overdue = 0;
#if STEERS
        heading = turn_rate = 0;
        motor[0] = motor[1] = 0;
        balance_steer_start(&steering, (real)wheel[0], (real)wheel[1]);
#endif
        note(gyro_sum / REST_TICKS, wheels, tilt_sum / REST_TICKS, 0, -1);
        rc_motor_set(0, 0.0);
        rc_motor_standby(0);
        balancing = 1;
        reason = 0;
    }
    last = now;
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

/* Take a command, cut to what the robot may do. */
static void want(double speed, double turn)
{
    if (!(fabs(speed) <= 1e6 && fabs(turn) <= 1e6))
        return;
    going = 0;
    wanted = (int)(1000 * cut(speed, SPEED));
#if STEERS
    wanted_turn = (int)(1000 * cut(turn, TURN_RATE));
#endif
    heard = milliseconds();
}

/* Take a place: one number, the way, or two of them, with the heading. */
static void go(int numbers, double way, double turn)
{
    if (!(fabs(way) <= 1e6 && fabs(turn) <= 1e6))
        return;
    going = 0;
    place = (int)(1000 * way);
#if STEERS
    bearing = (int)(1000 * turn);
#endif
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
        want(SPEED * stick(DSM_SPEED, DSM_SPEED_POLARITY),
            TURN_RATE * stick(DSM_TURN, DSM_TURN_POLARITY));
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
                "%.4g,%d,%d", row[n].t, row[n].gyro, row[n].wheels,
                row[n].tilt, row[n].target, row[n].rate, row[n].volts,
                row[n].theta, row[n].battery, row[n].fault, row[n].late);
#if STEERS
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
        waited = rc_get_state() == RUNNING && !balancing ? waited + 1 : 0;
        if (waited % 60 == 59 && why_waiting[0]) {
            printf("waiting: %s\n", why_waiting);
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
#if STEERS
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
