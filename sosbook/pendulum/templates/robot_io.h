/* robot_io.h: what a program of this folder asks of your board
 *
 * robot_io.cpp answers it for an MPU-6050, two quadrature encoders and a
 * motor driver with two direction pins and a PWM pin for each motor. Its
 * pins are examples: put yours there, or write the functions anew.
 *
 * Signs: forward is positive. Tip the body forward: tilt and gyro are
 * positive. Roll a wheel forward: its encoder grows. A positive voltage
 * drives the wheel forward.
 */
#ifndef ROBOT_IO_H
#define ROBOT_IO_H

bool io_begin(void);       /* false if a sensor doesn't answer */
bool io_read(void);        /* read the IMU; false: a bad reading */
float io_gyro(void);       /* rad/s, theta', at the last io_read */
float io_tilt(void);       /* rad, theta from the accelerometers */
long io_encoder(int side); /* of the left (0) or the right (1): so many a turn
                              of the wheel as the description's counts */
float io_supply(void);     /* V that the driver is fed with */
void io_drive(int side, float volts);

#endif
