/* The common code of the peers: the scene in memory, the pixel rule, the image, the clock, and samples printed as JSON. */
#pragma once

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

struct scene {
  float viewport[3];
  uint8_t background[3];
  unsigned count;
  float *spheres;   /* x, y, z, radius of each, aligned for SIMD, padded at the end */
  uint8_t *colours; /* r, g, b of each */
};

static inline void fail(const char *what) {
  fprintf(stderr, "%s\n", what);
  exit(1);
}

static inline double milliseconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static inline void print_samples(const char *name, const double *samples, int count) {
  printf("\"%s\": [", name);
  for (int i = 0; i < count; i++) printf("%s%.4f", i ? ", " : "", samples[i]);
  printf("]");
}

/* Next token as text; a comment runs to the end of its line. */
static inline char *next_token(char **text) {
  char *p = *text;
  for (;;) {
    while (*p == ' ' || (*p >= '\t' && *p <= '\r')) p++;
    if (*p != '#') break;
    while (*p && *p != '\n') p++;
  }
  if (!*p) fail("the scene ends too early");
  char *token = p;
  while (*p > ' ' && *p != '#') p++;
  *text = p;
  return token;
}

static inline float next_float(char **text) { return strtof(next_token(text), NULL); }

static inline struct scene read_scene(const char *path) {
  FILE *file = fopen(path, "rb");
  if (!file) fail("cannot open the scene");
  fseek(file, 0, SEEK_END);
  size_t bytes = (size_t)ftell(file);
  rewind(file);
  char *buffer = (char *)malloc(bytes + 1);
  if (fread(buffer, 1, bytes, file) != bytes) fail("cannot read the scene");
  fclose(file);
  buffer[bytes] = 0;

  struct scene scene;
  char *text = buffer;
  next_token(&text);
  for (int i = 0; i < 3; i++) scene.viewport[i] = next_float(&text);
  next_token(&text);
  for (int i = 0; i < 3; i++) scene.background[i] = (uint8_t)next_float(&text);
  next_token(&text);
  scene.count = (unsigned)strtoul(next_token(&text), NULL, 10);
  size_t space = ((size_t)scene.count + 16) * 4 * sizeof(float) / 64 * 64 + 64;
  scene.spheres = (float *)aligned_alloc(64, space);
  scene.colours = (uint8_t *)malloc((size_t)scene.count * 3 + 3);
  for (unsigned k = 0; k < scene.count; k++) {
    next_token(&text);
    for (int i = 0; i < 4; i++) scene.spheres[4 * (size_t)k + i] = next_float(&text);
    for (int i = 0; i < 3; i++) scene.colours[3 * (size_t)k + i] = (uint8_t)next_float(&text);
  }
  free(buffer);
  return scene;
}

enum { PIXELS_PADDED = 32 }; /* positions past the edge, so that the last packet of a row can be whole */

/* The ray of pixel (i, j) is (x[i], -y[j], viewport[2]): row 0 is the +y edge. */
static inline float *pixel_positions(float extent, int count) {
  float *at = (float *)malloc(((size_t)count + PIXELS_PADDED) * sizeof(float));
  for (int i = 0; i < count + PIXELS_PADDED; i++)
    at[i] = count == 1 ? 0.0f : (float)((double)extent * ((double)i / (count - 1) - 0.5));
  return at;
}

static inline void write_image(const char *path, const uint8_t *rgb, int width, int height) {
  FILE *file = fopen(path, "wb");
  if (!file) fail("cannot make the image");
  fprintf(file, "P6\n%d %d\n255\n", width, height);
  if (fwrite(rgb, 3, (size_t)width * height, file) != (size_t)width * height) fail("cannot write the image");
  fclose(file);
}
