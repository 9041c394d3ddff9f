/* compare A.ppm B.ppm: prints how many pixels differ. */
#include "scene.h"

/* A number of the header, past white space and comments. */
static unsigned header_number(FILE *file) {
  unsigned number;
  while (fscanf(file, " %u", &number) != 1) {
    if (fgetc(file) != '#') fail("not a PPM");
    for (int c = 0; c != '\n';)
      if ((c = fgetc(file)) == EOF) fail("not a PPM");
  }
  return number;
}

static uint8_t *read_image(const char *path, unsigned *width, unsigned *height) {
  FILE *file = fopen(path, "rb");
  if (!file || fgetc(file) != 'P' || fgetc(file) != '6') fail(path);
  *width = header_number(file);
  *height = header_number(file);
  if (header_number(file) != 255) fail(path);
  fgetc(file);
  size_t bytes = (size_t)*width * *height * 3;
  uint8_t *rgb = malloc(bytes);
  if (fread(rgb, 1, bytes, file) != bytes) fail(path);
  fclose(file);
  return rgb;
}

int main(int argc, char **argv) {
  if (argc != 3) fail("usage: compare A.ppm B.ppm");
  unsigned width, height, other_width, other_height;
  uint8_t *a = read_image(argv[1], &width, &height), *b = read_image(argv[2], &other_width, &other_height);
  if (width != other_width || height != other_height) fail("the sizes differ");
  size_t wrong = 0;
  for (size_t i = 0; i < (size_t)width * height; i++) wrong += memcmp(a + 3 * i, b + 3 * i, 3) != 0;
  printf("%zu\n", wrong);
  return 0;
}
