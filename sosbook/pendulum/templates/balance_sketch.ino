/* balance_sketch.ino: balance a robot with an Arduino, an ESP32 or the like
 *
 * (Where this comes from.)
 *
 * robot_io.cpp reads the sensors and drives the motors; its pins and signs
 * are examples. FIRST check the signs, wheels in the air: with the letter c
 * the sketch prints what the sensors say and leaves the motors off. Tip the
 * body forward: tilt and gyro are positive. Roll a wheel forward: it grows.
 *
 * The robot waits until it is held still near upright for a second, takes
 * the gyro's mean as its offset, and balances. Lines by the serial monitor
 * (500000 baud, with a newline):
 *   c      print the sensors, motors off
 *   g      wait for rest and balance (so it begins)
 *   s      stop
 *   l      log every tick, for sosbook.mip's compare; again: don't
 *   v 2.5  roll with 2.5 rad/s, reached on a ramp; say it again within a
 *          second, or the robot stops
 *   v 2.5 0.5  with STEERS 1: and turn left with 0.5 rad/s
 *   p 30   go where the wheels have rolled 30 rad since the start, and stay
 *   p 30 1.57  with STEERS 1: and head 1.57 rad to the left of the start
 */
#include "robot_io.h"
#include "balance_single.h"

#define STEERS 1 /* 1: a heading is held; 0: both motors get the same */
#if STEERS
#include "balance_single_steer.h"
#endif

static const unsigned long TICK = 10000UL; /* us */
static const unsigned long JITTER = 500UL; /* us, by which a tick may come late */
static const unsigned long LATE = 0UL; /* more late ticks than others; 0: any */
static const float HERTZ = 100.0f;
static const float TURN = 6.2831853f / 2122.2f; /* rad a count */
static const float SPEED = 0.0f; /* rad/s, at most */
static const float ACCELERATION = 0.0f; /* rad/s^2 */
static const float GENTLE = 0.3f; /* of these, on the way to a place: hardly passed */
#if STEERS
static const float TURN_RATE = 0.0f; /* rad/s of the heading, at most */
static const float TURN_ACCELERATION = 0.0f; /* rad/s^2 */
static const float PER_RADIAN = 2.5f; /* rad right less left, per rad */
#endif
static const unsigned long SILENCE = 1000000UL; /* us without a command */
static const float FARTHEST = 1e4f; /* rad, of a place: a float's digits end there */
static const int REST_TICKS = 100;
static const float REST_TILT = 0.2f, REST_GYRO = 0.1f, REST_TURN = 0.05f;
static const char *const REASON[] = {"running", "sensor", "fall", "stall", "command",
    "late"};

static const char COLUMNS[] =
    "t,gyro,wheels,tilt,target,rate,V,theta,battery,fault,late"
#if STEERS
    ",left,right,V_left,V_right,heading"
#endif
    ;

enum { STOPPED, WAITING, BALANCING, CHECKING };
static balance_single_state robot;
static int mode = WAITING;
static bool logging;
static int calm;
static float gyro_sum, tilt_sum, wheels_at_rest;
static float wanted, target, rate;
static int going; /* numbers of a place to go to: the way, and the heading */
static float place, bearing; /* rad since the start */
static unsigned long begun, next, heard; /* us */
static unsigned long late, overdue; /* ticks: all of them, and less the others */
#if STEERS
static balance_single_steering steering;
static float wheel[2], motor[2]; /* left and right: rad, V */
static float heading, turn_rate, wanted_turn; /* rad, rad/s */
#endif
static const char *why_waiting = "";
static unsigned waited;
static char line[24];
static uint8_t length;

static void drive(float volts)
{
    io_drive(0, volts);
    io_drive(1, volts);
}

static float cut(float x, float bound)
{
    return x > bound ? bound : x < -bound ? -bound : x;
}

#if STEERS
/* With a battery that hasn't the volts, balance is first. */
static void drive_both(void)
{
    const float most = io_supply();
    const float mean = cut((motor[0] + motor[1]) / 2, most);
    const float half = cut((motor[1] - motor[0]) / 2,
        most - (mean < 0 ? -mean : mean));
    io_drive(0, mean - half);
    io_drive(1, mean + half);
}
#endif

static void change(int to)
{
    drive(0);
    mode = to;
    calm = 0;
}

/* Microseconds as seconds: a float has too few digits. */
static void print_time(unsigned long t)
{
    Serial.print(t / 1000000UL);
    Serial.print('.');
    for (unsigned long power = 100000UL; power > 0; power /= 10)
        Serial.print((int)(t / power % 10));
}

static void print(float x)
{
    Serial.print(',');
    Serial.print(x, 7);
}

static void note(unsigned long now, float gyro, float wheels, float tilt,
    float volts, int fault)
{
    if (!logging)
        return;
    print_time(now - begun);
    print(gyro);
    print(wheels);
    print(tilt);
    print(target);
    print(rate);
    print(volts);
    print(robot.theta);
    print(io_supply());
    Serial.print(',');
    Serial.print(fault);
    Serial.print(',');
    Serial.print(late);
#if STEERS
    print(wheel[0]);
    print(wheel[1]);
    print(motor[0]);
    print(motor[1]);
    print(heading);
#endif
    Serial.println("");
}

static void want(float speed, float turn)
{
    going = 0;
    wanted = cut(speed, SPEED);
#if STEERS
    wanted_turn = cut(turn, TURN_RATE);
#else
    (void)turn;
#endif
}

/* The speed from which it stops just when nothing is left. */
static float stopping(float left, float most, float acceleration)
{
    const float way = left < 0 ? -left : left, step = acceleration / HERTZ;
    const float speed = sqrtf(step * step / 4 + 2 * acceleration * way) - step / 2;
    return cut(left * HERTZ, speed < most ? speed : most);
}

static void ramp(void)
{
    const float share = going > 0 ? GENTLE : 1.0f;
    if (going > 0)
        wanted = stopping(place - target, SPEED, share * ACCELERATION);
    rate += cut(wanted - rate, share * ACCELERATION / HERTZ);
    target += rate / HERTZ;
#if STEERS
    if (going > 0)
        wanted_turn = going < 2 ? 0 :
            stopping(bearing - heading, share * TURN_RATE, share * TURN_ACCELERATION);
    turn_rate += cut(wanted_turn - turn_rate, share * TURN_ACCELERATION / HERTZ);
    heading += turn_rate / HERTZ;
#endif
}

static bool within(float x, float bound)
{
    return x >= -bound && x <= bound;
}

static bool at_rest(float gyro, float wheels, float tilt)
{
    if (calm == 0 || !within(tilt, REST_TILT) || !within(gyro, REST_GYRO) ||
        !within(wheels - wheels_at_rest, REST_TURN)) {
        why_waiting = !within(tilt, REST_TILT) ? "hold it upright" :
            !within(gyro, REST_GYRO) ? "hold it still, the gyro turns" :
            calm > 0 ? "hold its wheels still" : "";
        wheels_at_rest = wheels;
        gyro_sum = tilt_sum = 0;
        calm = 1;
        return false;
    }
    gyro_sum += gyro;
    tilt_sum += tilt;
    return calm++ == REST_TICKS;
}

/* By so much does the tick come late, in us: phi' is wrong then, and the law. */
static void mind(unsigned long by)
{
    const unsigned long lost = by / TICK;
    if (by > JITTER) {
        late++;
        overdue += 1 + lost;
    } else if (overdue > 0) {
        overdue--;
    }
    if (LATE > 0 && overdue > LATE)
        robot.fault = BALANCE_SINGLE_LATE;
}

static void tick(unsigned long now)
{
    const bool read = io_read();
    const float gyro = read ? io_gyro() : NAN, tilt = read ? io_tilt() : NAN;
#if STEERS
    wheel[0] = TURN * (float)io_encoder(0);
    wheel[1] = TURN * (float)io_encoder(1);
    const float wheels = (wheel[0] + wheel[1]) / 2;
#else
    const float wheels = TURN * (float)(io_encoder(0) + io_encoder(1)) / 2;
#endif

    if (mode == BALANCING) {
        if (going == 0 && now - heard > SILENCE)
            want(0, 0);
        mind(now - next);
        ramp();
        const float volts = balance_single_step(&robot, gyro, wheels, tilt,
            target, rate);
#if STEERS
        balance_single_steer(&steering, &robot, wheel[0], wheel[1],
            PER_RADIAN * heading, PER_RADIAN * turn_rate, motor);
        drive_both();
#else
        drive(volts);
#endif
        note(now, gyro, wheels, tilt, volts, robot.fault);
        if (robot.fault) {
            change(STOPPED);
            Serial.print("# motors off: ");
            Serial.println(REASON[robot.fault]);
        }
    } else if (mode == WAITING && !at_rest(gyro, wheels, tilt)) {
        if (++waited % (3 * (unsigned)REST_TICKS) == 0 && why_waiting[0]) {
            Serial.print("# waiting: ");
            Serial.println(why_waiting);
        }
    } else if (mode == WAITING) {
        const float mean = tilt_sum / (float)REST_TICKS;
        const float bias = gyro_sum / (float)REST_TICKS;
        balance_single_start(&robot, mean, wheels, bias);
        wanted = target = rate = 0;
        going = 0;
        late = overdue = 0;
#if STEERS
        heading = turn_rate = wanted_turn = motor[0] = motor[1] = 0;
        balance_single_steer_start(&steering, wheel[0], wheel[1]);
#endif
        mode = BALANCING;
        note(now, bias, wheels, mean, 0, -1);
    } else if (mode == CHECKING && calm++ % 50 == 0) {
        Serial.print("# tilt, gyro, wheels: ");
        Serial.print(tilt, 3);
        print(gyro);
        print(TURN * (float)io_encoder(0));
        print(TURN * (float)io_encoder(1));
        Serial.println("");
    }
}

static void obey(void)
{
    if (line[0] == 'c')
        change(CHECKING);
    if (line[0] == 'g')
        change(WAITING);
    if (line[0] == 's')
        change(STOPPED);
    if (line[0] == 'v' || line[0] == 'p') {
        char *end, *last;
        const float x = (float)strtod(line + 1, &end);
        const float turn = (float)strtod(end, &last);
        want(line[0] == 'v' ? x : 0, line[0] == 'v' ? turn : 0);
        heard = micros();
        if (line[0] == 'p' && within(x, FARTHEST) && within(turn, FARTHEST)) {
            place = x;
            bearing = turn;
            going = last > end ? 2 : end > line + 1 ? 1 : 0;
        }
    }
    if (line[0] == 'l') {
        logging = !logging;
        if (logging)
            Serial.println(COLUMNS);
    }
}

void setup(void)
{
    Serial.begin(500000);
    if (!io_begin()) {
        Serial.println("# a sensor doesn't answer");
        mode = STOPPED;
    }
    drive(0);
    begun = next = micros();
}

void loop(void)
{
    while (Serial.available()) {
        const char letter = (char)Serial.read();
        if (letter != '\n' && length < sizeof line - 1) {
            line[length++] = letter;
            continue;
        }
        line[length] = 0;
        length = 0;
        obey();
    }
    const unsigned long now = micros();
    if ((long)(now - next) < 0)
        return;
    tick(now);
    next = now + TICK; /* a late tick is never followed by a short one */
}
