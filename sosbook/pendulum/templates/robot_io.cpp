/* robot_io.cpp: see robot_io.h. Every pin and sign here is an example.
 *
 * (Where this comes from.)
 */
#include <Arduino.h>
#include <Wire.h>
#include <math.h>
#include "robot_io.h"

/* Left and right. */
static const uint8_t ENCODER_A[2] = {2, 3}; /* pins with interrupts */
static const uint8_t ENCODER_B[2] = {4, 5};
static const uint8_t FORWARD[2] = {7, 8};
static const uint8_t BACKWARD[2] = {9, 10};
static const uint8_t PWM_PIN[2] = {6, 11};
static const int MOTOR_POLARITY[2] = {1, -1};
static const int ENCODER_POLARITY[2] = {1, -1};

static const float SUPPLY = 7.4f; /* V; better: measure it */
static const uint8_t IMU = 0x68;
static const float GYRO_STEP = 0.000532632218f; /* rad/s a count of the gyro */
static const uint8_t GYRO_RANGE = 0x10; /* of the register 0x1B */

#define COUNTS 2122.2 /* of the description, per turn of a wheel, from */
#define EDGES 4 /* edges of each period of both channels */
#define SEEN 2 /* of them here; each is worth more, then */
static const int WORTH = EDGES / SEEN;

static volatile long count[2];
static float gyro, tilt;

static void encoder(int side)
{
    const int up = digitalRead(ENCODER_A[side]) == digitalRead(ENCODER_B[side]);
    count[side] += (up ? WORTH : -WORTH) * ENCODER_POLARITY[side];
}

static void left_moved(void) { encoder(0); }
static void right_moved(void) { encoder(1); }

static bool set_register(uint8_t where, uint8_t what)
{
    Wire.beginTransmission(IMU);
    Wire.write(where);
    Wire.write(what);
    return Wire.endTransmission() == 0;
}

bool io_begin(void)
{
    for (int side = 0; side < 2; side++) {
        pinMode(ENCODER_A[side], INPUT_PULLUP);
        pinMode(ENCODER_B[side], INPUT_PULLUP);
        pinMode(FORWARD[side], OUTPUT);
        pinMode(BACKWARD[side], OUTPUT);
        pinMode(PWM_PIN[side], OUTPUT);
    }
    /* Where B's pins have interrupts, too, all four edges can be counted: with
     * functions of their own, in which up is the opposite, and WORTH halved. */
    const int edge = SEEN == 2 ? CHANGE : RISING;
    attachInterrupt(digitalPinToInterrupt(ENCODER_A[0]), left_moved, edge);
    attachInterrupt(digitalPinToInterrupt(ENCODER_A[1]), right_moved, edge);
    Wire.begin();
    Wire.setClock(400000);
    return set_register(0x6B, 0) && set_register(0x1A, 1) &&
        set_register(0x1B, GYRO_RANGE) && set_register(0x1C, 0);
}

static int word16(void)
{
    const int high = Wire.read();
    const int both = high * 256 + Wire.read();
    return both > 32767 ? both - 65536 : both;
}

bool io_read(void)
{
    Wire.beginTransmission(IMU);
    Wire.write(0x3B);
    if (Wire.endTransmission(false) != 0 || Wire.requestFrom(IMU, (uint8_t)14) != 14)
        return false;
    const int x = word16();
    word16();
    const int z = word16();
    word16(); /* temperature */
    word16();
    const int rate = word16();
    word16();
    tilt = atan2f((float)x, (float)z);
    gyro = GYRO_STEP * (float)rate;
    return true;
}

float io_gyro(void) { return gyro; }

float io_tilt(void) { return tilt; }

long io_encoder(int side)
{
    noInterrupts();
    const long counted = count[side];
    interrupts();
    return counted;
}

float io_supply(void) { return SUPPLY; }

void io_drive(int side, float volts)
{
    float duty = (float)MOTOR_POLARITY[side] * volts / io_supply();
    duty = duty > 1 ? 1 : duty < -1 ? -1 : duty;
    digitalWrite(FORWARD[side], duty > 0 ? HIGH : LOW);
    digitalWrite(BACKWARD[side], duty < 0 ? HIGH : LOW);
    analogWrite(PWM_PIN[side], (int)(255 * fabsf(duty) + 0.5f));
}
