/* identify.ino: record the logs of the two experiments
 *
 * (Where this comes from.)
 *
 * Send a letter by the serial monitor (500000 baud, no line ending):
 *   b  the robot is held by its wheels, upside down, its body at rest
 *   w  it lies on its back, wheels in the air
 *   any other letter stops the motors
 * Save what comes, from the line that begins with t,V to the one before
 * "end", as body.csv and wheels.csv. In each line the sensors were read
 * before its V began to act.
 */
#include "robot_io.h"

static const unsigned long TICK = 10000UL; /* us */
static const unsigned long SHORTEST = TICK - TICK / 20; /* us, of a late one's next */
static const float HERTZ = 100.0f;
static const float SECONDS = 30.0f; /* s, of the sweep, either way */
static const long ROWS = 6000;
/* The sweep's ends in Hz, and the sine's amplitude in V. */
static const float BODY[3] = {1.1f, 21.0f, 1.85f};
static const float WHEELS[3] = {0.3f, 30.0f, 5.92f};
/* Of that, what a motor gets that drives the body alone, on the sweep's way back. */
static const float ALONE = 2.0f;

static const float *sweep = 0; /* not while the motors are off */
static long row;
static float turns; /* of the sine, so far */
static unsigned long first, next; /* us */

/* Both motors, or the left (1) or the right one (2) alone. */
static void drive(float volts, int alone)
{
    io_drive(0, alone == 2 ? 0 : volts);
    io_drive(1, alone == 1 ? 0 : volts);
}

static void stop(void)
{
    drive(0, 0);
    if (sweep)
        Serial.println("end");
    sweep = 0;
}

static void begin(const float *ends, const char *names)
{
    Serial.println(names);
    sweep = ends;
    row = 0;
    turns = 0;
    first = next = micros();
}

/* The sine's next value; its frequency goes up and comes back. */
static float chirp(float t)
{
    const float s = t < SECONDS ? t : 2 * SECONDS - t;
    const float volts = sweep[2] * sinf(6.2831853f * turns);
    turns += (sweep[0] + (sweep[1] - sweep[0]) * s / SECONDS) / HERTZ;
    turns -= floorf(turns);
    return volts;
}

/* Microseconds as seconds: a float has too few digits. */
static void print_time(unsigned long t)
{
    const unsigned long rest = t % 1000000UL;
    Serial.print(t / 1000000UL);
    Serial.print('.');
    for (unsigned long power = 100000UL; power > 0; power /= 10)
        Serial.print((int)(rest / power % 10));
}

void setup(void)
{
    Serial.begin(500000);
    if (!io_begin())
        Serial.println("a sensor doesn't answer");
    drive(0, 0);
}

void loop(void)
{
    if (Serial.available()) {
        const int letter = Serial.read();
        stop();
        if (letter == 'b')
            begin(BODY, "t,V,gyro,alone");
        if (letter == 'w')
            begin(WHEELS, "t,V,encoder1,encoder2");
    }
    if (!sweep || (long)(micros() - next) < 0)
        return;
    const unsigned long now = micros();
    next += TICK;
    if ((long)(now + SHORTEST - next) > 0)
        next = now + SHORTEST; /* no short tick follows a late one */
    if (!io_read()) {
        Serial.println("the IMU doesn't answer");
        stop();
        return;
    }
    const long left = io_encoder(0), right = io_encoder(1);
    const float t = (float)row / HERTZ;
    const int alone = sweep == BODY && t >= SECONDS ? 1 + (int)t % 2 : 0;
    float volts = chirp(t);
    drive(alone ? ALONE * volts : volts, alone);
    if (alone)
        volts *= ALONE / 2; /* the mean of both motors' */
    print_time(now - first);
    Serial.print(',');
    Serial.print(volts, 4);
    Serial.print(',');
    if (sweep == BODY) {
        Serial.print(io_gyro(), 5);
        Serial.print(',');
        Serial.println(alone);
    } else {
        Serial.print(left);
        Serial.print(',');
        Serial.println(right);
    }
    if (++row == ROWS)
        stop();
}
