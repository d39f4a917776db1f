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
 *   l      log every tick, for sosbook.pendulum's compare; again: don't
 *   v 2.5  roll with 2.5 rad/s, reached on a ramp; say it again within a
 *          second, or the robot stops
 *   v 2.5 0.5  where the heading is held: and turn left with 0.5 rad/s
 *   p 30   go where the wheels have rolled 30 rad since the start, and stay
 *   p 30 1.57  likewise: and head 1.57 rad to the left of the start
 */
#include "robot_io.h"
#include "balance_single_run.h"

static const unsigned long TICK = BALANCE_SINGLE_TICK_US;
static const float TURN = 6.2831853f / 2122.2f; /* rad a count */
static const unsigned long SILENCE = 1000000UL; /* us without a command */
static const char *const REASON[] = {"running", "sensor", "fall", "stall", "command",
    "late"};

static const char COLUMNS[] =
    "t,gyro,wheels,tilt,target,rate,V,theta,battery,fault,late"
#if BALANCE_SINGLE_STEERS
    ",left,right,V_left,V_right,heading"
#endif
    ;

enum { STOPPED, RUNNING, CHECKING };
static balance_single_run run;
static int mode = RUNNING;
static bool logging;
static unsigned waited; /* ticks */
static unsigned long begun, next, heard; /* us */
static char line[24];
static uint8_t length;

static void drive(void)
{
    float volts[2];
    balance_single_run_volts(&run, io_supply(), volts);
    io_drive(0, volts[0]);
    io_drive(1, volts[1]);
}

static void change(int to)
{
    io_drive(0, 0);
    io_drive(1, 0);
    balance_single_run_stop(&run);
    mode = to;
    waited = 0;
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

static void note(unsigned long now, float gyro, const float wheel[2], float tilt,
    int fault)
{
    if (!logging)
        return;
    print_time(now - begun);
    print(gyro);
    print((wheel[0] + wheel[1]) / 2);
    print(tilt);
    print(run.target);
    print(run.rate);
    print(run.volts);
    print(run.theta);
    print(io_supply());
    Serial.print(',');
    Serial.print(fault);
    Serial.print(',');
    Serial.print(run.late);
#if BALANCE_SINGLE_STEERS
    print(wheel[0]);
    print(wheel[1]);
    print(run.motor[0]);
    print(run.motor[1]);
    print(run.heading);
#endif
    Serial.println("");
}

static void tick(unsigned long now)
{
    const bool read = io_read();
    const float gyro = read ? io_gyro() : NAN, tilt = read ? io_tilt() : NAN;
    const float wheel[2] = {TURN * (float)io_encoder(0), TURN * (float)io_encoder(1)};

    if (mode == CHECKING && waited++ % 50 == 0) {
        Serial.print("# tilt, gyro, wheels: ");
        Serial.print(tilt, 3);
        print(gyro);
        print(wheel[0]);
        print(wheel[1]);
        Serial.println("");
    }
    if (mode != RUNNING)
        return;
    if (now - heard > SILENCE)
        run.speed = run.turn = 0;
    switch (balance_single_run_tick(&run, gyro, wheel[0], wheel[1], tilt,
        1e-6f * (float)(now - next + TICK))) {
    case BALANCE_SINGLE_WAITED:
        if (++waited % (3U * BALANCE_SINGLE_REST_TICKS) == 0 && run.waiting[0]) {
            Serial.print("# waiting: ");
            Serial.println(run.waiting);
        }
        break;
    case BALANCE_SINGLE_STARTED:
        note(now, run.bias, wheel, run.theta, -1);
        break;
    default:
        drive();
        note(now, gyro, wheel, tilt, run.fault);
        if (run.fault) {
            change(STOPPED);
            Serial.print("# motors off: ");
            Serial.println(REASON[run.fault]);
        }
    }
}

static void obey(void)
{
    if (line[0] == 'c')
        change(CHECKING);
    if (line[0] == 'g')
        change(RUNNING);
    if (line[0] == 's')
        change(STOPPED);
    if (line[0] == 'v' || line[0] == 'p') {
        char *end, *last;
        const float x = (float)strtod(line + 1, &end);
        const float turn = (float)strtod(end, &last);
        run.speed = line[0] == 'v' ? x : 0;
        run.turn = line[0] == 'v' ? turn : 0;
        run.place = x;
        run.bearing = turn;
        run.going = line[0] == 'v' ? 0 : last > end ? 2 : end > line + 1 ? 1 : 0;
        heard = micros();
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
    io_drive(0, 0);
    io_drive(1, 0);
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
