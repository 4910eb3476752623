/* Types of generated code, for a machine with 32-bit int. */
#ifndef RTWTYPES_H
#define RTWTYPES_H

typedef signed char int8_T;
typedef unsigned char uint8_T;
typedef short int16_T;
typedef unsigned short uint16_T;
typedef int int32_T;
typedef unsigned int uint32_T;
typedef float real32_T;
typedef unsigned char boolean_T;

#define MAX_int8_T 127
#define MIN_int8_T (-128)
#define MAX_uint8_T 255U
#define MIN_uint8_T 0U
#define MAX_int16_T 32767
#define MIN_int16_T (-32768)
#define MAX_uint16_T 65535U
#define MIN_uint16_T 0U
#define MAX_int32_T 2147483647
#define MIN_int32_T (-2147483647 - 1)
#define MAX_uint32_T 4294967295U
#define MIN_uint32_T 0U
#define MAX_boolean_T 1U
#define MIN_boolean_T 0U

#endif
