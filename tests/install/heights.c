/* Prints what a pack says of itself and the heights at places. */
#include <cairn/cairn.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv) {
  if (argc < 4) return fprintf(stderr, "usage: heights PACK LON LAT [LON LAT]...\n"), 2;
  cairn_error error;
  cairn_pack *pack;
  const cairn_result opened = cairn_open(argv[1], &pack, &error);
  if (opened != CAIRN_OK) return fprintf(stderr, "%s\n", error.text), opened;

  const size_t count = (size_t)(argc - 2) / 2;
  double *lon = malloc(3 * count * sizeof *lon);
  double *lat = lon + count, *height_m = lat + count;
  for (size_t i = 0; i < count; ++i) {
    lon[i] = atof(argv[2 + 2 * i]);
    lat[i] = atof(argv[3 + 2 * i]);
  }
  const cairn_result sampled = cairn_sample_heights(pack, count, lon, lat, height_m, &error);
  if (sampled != CAIRN_OK) fprintf(stderr, "%s\n", error.text);
  for (size_t i = 0; i < count; ++i) printf("%g %g %.4f\n", lon[i], lat[i], height_m[i]);
  printf("%.40s...\n", cairn_info(pack));

  free(lon);
  cairn_close(pack);
  return sampled;
}
