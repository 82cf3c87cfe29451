/* The C interface of cairn: reads packs. C99 and later, and what can call C.
 *
 * Threads: any number of threads may call any function on one pack at once, but for cairn_close(), after
 * which nothing may use the pack. No function uses global state or prints.
 *
 * Errors: a function that fails returns a cairn_result other than CAIRN_OK and, where `error` is not NULL,
 * writes one line of text, "FILE: PLACE: expected X, found Y". */
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum cairn_result {
  CAIRN_OK = 0,
  CAIRN_FAILED = 1,   /* the machine: I/O, memory */
  CAIRN_USAGE = 2,    /* the caller's arguments */
  CAIRN_BAD_DATA = 3, /* the file's bytes */
  CAIRN_ABSENT = 4    /* the pack has no such tile */
} cairn_result;

/* The text of the last failure of the call that it was given to; empty after a success. */
typedef struct cairn_error {
  char text[1024]; /* UTF-8, cut off where it is longer */
} cairn_error;

typedef struct cairn_pack cairn_pack;

/* The library's version, "MAJOR.MINOR.PATCH". */
const char *cairn_version(void);

/* Opens a pack and stores it in *pack; NULL after a failure. */
cairn_result cairn_open(const char *path, cairn_pack **pack, cairn_error *error);

/* Closes a pack; NULL is allowed. */
void cairn_close(cairn_pack *pack);

/* What the pack holds, as JSON text in UTF-8; docs/pack-format.md lists the keys. Valid until cairn_close(). */
const char *cairn_info(const cairn_pack *pack);

/* Samples along a side of a height tile: 513 or 257. An imagery tile has one texel less. */
int cairn_tile_size(const cairn_pack *pack);

/* Stores the heights at `count` places, in metres in the pack's vertical datum, bilinear between the samples
 * of the finest tile that covers a place. NaN where the pack has no height.
 * lon, lat: degrees, `count` each; longitudes may have any number of turns. Neighbouring places are quickest
 * one after the other. A failure names the first tile that could not be read, and leaves the rest NaN. */
cairn_result cairn_sample_heights(const cairn_pack *pack, size_t count, const double *lon, const double *lat,
                                  double *height_m, cairn_error *error);

/* Stores the tile's heights, in metres: cairn_tile_size() squared samples, columns from west to east, rows
 * from SOUTH to north, NaN where a sample is void. Level L tiles are 2^-L degrees wide; x and y count them
 * from 180 degrees west and 90 degrees south.
 * usage where `count` is another number of samples; CAIRN_ABSENT where the pack has no such tile. */
cairn_result cairn_read_heights(const cairn_pack *pack, int level, int32_t x, int32_t y, float *height_m,
                                size_t count, cairn_error *error);

/* Stores the tile's imagery as RGBA bytes in sRGB: (cairn_tile_size() - 1) squared texels of 4 bytes, rows
 * from NORTH to south.
 * usage where `count` is another number of bytes; CAIRN_ABSENT where the pack has no such tile. */
cairn_result cairn_read_imagery(const cairn_pack *pack, int level, int32_t x, int32_t y, uint8_t *rgba,
                                size_t count, cairn_error *error);

#ifdef __cplusplus
}
#endif
