// Embree 3 or 4 on the same spheres: its own sphere geometry and user geometry with an 8-wide sphere test, by single
// rays, packets of 8 and 16, and (Embree 3) streams, over trees of medium and low build quality.
//
//     embree SCENE WIDTH HEIGHT THREADS RUNS [MODE [IMAGE]]
//
// Prints one line of JSON for each mode, times in milliseconds from spheres in memory to RGB in memory: build (scene, geometry,
// commit) and trace. MODE is one of the printed names; without it all are run. Closing the scene is not counted.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#define EMBREE 4
#else
#include <embree3/rtcore.h>
#define EMBREE 3
#endif

#include <immintrin.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "scene.h"

namespace {

const float INFINITE = std::numeric_limits<float>::infinity();
const float *spheres;

void bounds(const RTCBoundsFunctionArguments *args) {
  const float *s = spheres + 4 * size_t(args->primID);
  RTCBounds *box = args->bounds_o;
  box->lower_x = s[0] - s[3], box->upper_x = s[0] + s[3];
  box->lower_y = s[1] - s[3], box->upper_y = s[1] + s[3];
  box->lower_z = s[2] - s[3], box->upper_z = s[2] + s[3];
}

// One sphere against N rays from the origin, 8 at a time: r^2 - |C - (C.V/V.V) V|^2 as in Embree's own sphere test.
void intersect(const RTCIntersectFunctionNArguments *args) {
  const float *s = spheres + 4 * size_t(args->primID);
  const unsigned n = args->N;
  RTCRayN *rays = RTCRayHitN_RayN(args->rayhit, n);
  RTCHitN *hits = RTCRayHitN_HitN(args->rayhit, n);
  if (n % 8) {
    for (unsigned i = 0; i < n; i++) {
      if (!args->valid[i]) continue;
      const float x = RTCRayN_dir_x(rays, n, i), y = RTCRayN_dir_y(rays, n, i), z = RTCRayN_dir_z(rays, n, i);
      const float reciprocal = 1.0f / (x * x + y * y + z * z);
      const float middle = (s[0] * x + s[1] * y + s[2] * z) * reciprocal;
      const float px = s[0] - middle * x, py = s[1] - middle * y, pz = s[2] - middle * z;
      const float d = s[3] * s[3] - (px * px + py * py + pz * pz);
      if (d < 0) continue;
      const float half = std::sqrt(d * reciprocal);
      const float t = middle - half > 0 ? middle - half : middle + half;
      float &far = RTCRayN_tfar(rays, n, i);
      if (t <= 0 || t >= far) continue;
      far = t;
      RTCHitN_primID(hits, n, i) = args->primID;
      RTCHitN_geomID(hits, n, i) = args->geomID;
    }
    return;
  }
  const __m256 cx = _mm256_set1_ps(s[0]), cy = _mm256_set1_ps(s[1]), cz = _mm256_set1_ps(s[2]);
  const __m256 r2 = _mm256_set1_ps(s[3] * s[3]), zero = _mm256_setzero_ps();
  for (unsigned i = 0; i < n; i += 8) {
    const __m256 x = _mm256_loadu_ps(&RTCRayN_dir_x(rays, n, i)), y = _mm256_loadu_ps(&RTCRayN_dir_y(rays, n, i)),
                 z = _mm256_loadu_ps(&RTCRayN_dir_z(rays, n, i));
    const __m256 a = _mm256_fmadd_ps(x, x, _mm256_fmadd_ps(y, y, _mm256_mul_ps(z, z)));
    const __m256 reciprocal = _mm256_div_ps(_mm256_set1_ps(1.0f), a);
    const __m256 b = _mm256_fmadd_ps(cx, x, _mm256_fmadd_ps(cy, y, _mm256_mul_ps(cz, z)));
    const __m256 middle = _mm256_mul_ps(b, reciprocal);
    const __m256 px = _mm256_fnmadd_ps(middle, x, cx), py = _mm256_fnmadd_ps(middle, y, cy),
                 pz = _mm256_fnmadd_ps(middle, z, cz);
    const __m256 p2 = _mm256_fmadd_ps(px, px, _mm256_fmadd_ps(py, py, _mm256_mul_ps(pz, pz)));
    const __m256 d = _mm256_sub_ps(r2, p2);
    __m256 hit = _mm256_and_ps(_mm256_cmp_ps(d, zero, _CMP_GE_OQ),
                               _mm256_castsi256_ps(_mm256_loadu_si256((const __m256i *)(args->valid + i))));
    if (!_mm256_movemask_ps(hit)) continue;
    const __m256 half = _mm256_sqrt_ps(_mm256_mul_ps(_mm256_max_ps(d, zero), reciprocal));
    const __m256 near = _mm256_sub_ps(middle, half), back = _mm256_add_ps(middle, half);
    const __m256 t = _mm256_blendv_ps(back, near, _mm256_cmp_ps(near, zero, _CMP_GT_OQ));
    float *tfar = &RTCRayN_tfar(rays, n, i);
    const __m256 far = _mm256_loadu_ps(tfar);
    hit = _mm256_and_ps(hit, _mm256_and_ps(_mm256_cmp_ps(t, zero, _CMP_GT_OQ), _mm256_cmp_ps(t, far, _CMP_LT_OQ)));
    _mm256_storeu_ps(tfar, _mm256_blendv_ps(far, t, hit));
    const __m256i lanes = _mm256_castps_si256(hit);
    _mm256_maskstore_epi32((int *)&RTCHitN_primID(hits, n, i), lanes, _mm256_set1_epi32(int(args->primID)));
    _mm256_maskstore_epi32((int *)&RTCHitN_geomID(hits, n, i), lanes, _mm256_set1_epi32(int(args->geomID)));
  }
}

enum class Rays { single, packets8, packets16, streams };

struct Picture {
  const scene &world;
  int width, height;
  float *x, *y;
  uint8_t *rgb;

  void put(int column, int row, unsigned seen) const {
    const uint8_t *colour = seen == RTC_INVALID_GEOMETRY_ID ? world.background : world.colours + 3 * size_t(seen);
    uint8_t *pixel = rgb + 3 * (size_t(row) * width + column);
    pixel[0] = colour[0], pixel[1] = colour[1], pixel[2] = colour[2];
  }
};

#if EMBREE == 4
void trace1(RTCScene s, RTCRayHit *r) {
  RTCIntersectArguments a;
  rtcInitIntersectArguments(&a);
  a.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect1(s, r, &a);
}
void trace8(const int *v, RTCScene s, RTCRayHit8 *r) {
  RTCIntersectArguments a;
  rtcInitIntersectArguments(&a);
  a.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(v, s, r, &a);
}
void trace16(const int *v, RTCScene s, RTCRayHit16 *r) {
  RTCIntersectArguments a;
  rtcInitIntersectArguments(&a);
  a.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(v, s, r, &a);
}
#else
RTCIntersectContext coherent() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}
void trace1(RTCScene s, RTCRayHit *r) {
  RTCIntersectContext c = coherent();
  rtcIntersect1(s, &c, r);
}
void trace8(const int *v, RTCScene s, RTCRayHit8 *r) {
  RTCIntersectContext c = coherent();
  rtcIntersect8(v, s, &c, r);
}
void trace16(const int *v, RTCScene s, RTCRayHit16 *r) {
  RTCIntersectContext c = coherent();
  rtcIntersect16(v, s, &c, r);
}
void trace_stream(RTCScene s, RTCRayHit *r, unsigned count) {
  RTCIntersectContext c = coherent();
  rtcIntersect1M(s, &c, r, count, sizeof(RTCRayHit));
}
#endif

RTCRayHit ray(const Picture &p, int column, int row) {
  RTCRayHit r;
  r.ray.org_x = r.ray.org_y = r.ray.org_z = 0;
  r.ray.dir_x = p.x[column], r.ray.dir_y = -p.y[row], r.ray.dir_z = p.world.viewport[2];
  r.ray.tnear = 0, r.ray.tfar = INFINITE;
  r.ray.time = 0, r.ray.mask = ~0u, r.ray.id = 0, r.ray.flags = 0;
  r.hit.geomID = r.hit.primID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return r;
}

// A block of 4 x (N/4) pixels; those outside the picture are masked.
template <int N, class Packet, class Trace>
void block(const Picture &p, RTCScene s, int column, int row, Trace trace) {
  alignas(64) int valid[N];
  Packet r;
  for (int i = 0; i < N; i++) {
    const int c = column + i % 4, w = row + i / 4;
    valid[i] = c < p.width && w < p.height ? -1 : 0;
    r.ray.org_x[i] = r.ray.org_y[i] = r.ray.org_z[i] = 0;
    r.ray.dir_x[i] = p.x[c], r.ray.dir_y[i] = -p.y[w], r.ray.dir_z[i] = p.world.viewport[2];
    r.ray.tnear[i] = 0, r.ray.tfar[i] = INFINITE;
    r.ray.time[i] = 0, r.ray.mask[i] = ~0u, r.ray.id[i] = 0, r.ray.flags[i] = 0;
    r.hit.geomID[i] = r.hit.primID[i] = r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  trace(valid, s, &r);
  for (int i = 0; i < N; i++)
    if (valid[i]) p.put(column + i % 4, row + i / 4, r.hit.primID[i]);
}

constexpr int TILE = 16;

void tile(const Picture &p, RTCScene s, Rays rays, int left, int top) {
  const int right = std::min(left + TILE, p.width), bottom = std::min(top + TILE, p.height);
  switch (rays) {
  case Rays::single:
    for (int row = top; row < bottom; row++)
      for (int column = left; column < right; column++) {
        RTCRayHit r = ray(p, column, row);
        trace1(s, &r);
        p.put(column, row, r.hit.primID);
      }
    break;
  case Rays::packets8:
    for (int row = top; row < bottom; row += 2)
      for (int column = left; column < right; column += 4) block<8, RTCRayHit8>(p, s, column, row, trace8);
    break;
  case Rays::packets16:
    for (int row = top; row < bottom; row += 4)
      for (int column = left; column < right; column += 4) block<16, RTCRayHit16>(p, s, column, row, trace16);
    break;
  case Rays::streams: {
#if EMBREE == 3
    RTCRayHit stream[TILE * TILE];
    unsigned count = 0;
    for (int row = top; row < bottom; row++)
      for (int column = left; column < right; column++) stream[count++] = ray(p, column, row);
    trace_stream(s, stream, count);
    count = 0;
    for (int row = top; row < bottom; row++)
      for (int column = left; column < right; column++) p.put(column, row, stream[count++].hit.primID);
#endif
    break;
  }
  }
}

void trace(const Picture &p, RTCScene s, Rays rays) {
  const int across = (p.width + TILE - 1) / TILE, down = (p.height + TILE - 1) / TILE;
  tbb::parallel_for(0, across * down, [&](int i) { tile(p, s, rays, i % across * TILE, i / across * TILE); });
}

RTCScene build(RTCDevice device, const scene &world, bool user, bool low) {
  RTCScene s = rtcNewScene(device);
  rtcSetSceneBuildQuality(s, low ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
  RTCGeometry g = rtcNewGeometry(device, user ? RTC_GEOMETRY_TYPE_USER : RTC_GEOMETRY_TYPE_SPHERE_POINT);
  rtcSetGeometryBuildQuality(g, low ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
  if (user) {
    rtcSetGeometryUserPrimitiveCount(g, world.count);
    rtcSetGeometryBoundsFunction(g, bounds, nullptr);
    rtcSetGeometryIntersectFunction(g, intersect);
  } else {
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, world.spheres, 0, 16, world.count);
  }
  rtcCommitGeometry(g);
  rtcAttachGeometry(s, g);
  rtcReleaseGeometry(g);
  rtcCommitScene(s);
  return s;
}

} // namespace

int main(int argc, char **argv) {
  if (argc < 6) fail("usage: embree SCENE WIDTH HEIGHT THREADS RUNS [MODE [IMAGE]]");
  const scene world = read_scene(argv[1]);
  spheres = world.spheres;
  const int width = atoi(argv[2]), height = atoi(argv[3]), threads = atoi(argv[4]), runs = atoi(argv[5]);
  const std::string wanted = argc > 6 ? argv[6] : "";

  _mm_setcsr(_mm_getcsr() | 0x8040); // flush to zero, denormals are zero, as Embree's manual asks
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
  tbb::task_arena arena(threads);
  RTCDevice device = rtcNewDevice(("threads=" + std::to_string(threads) + ",set_affinity=0").c_str());
  if (!device) fail("Embree cannot open a device");
  rtcSetDeviceErrorFunction(device, [](void *, RTCError, const char *text) { fail(text); }, nullptr);
  const bool streams = EMBREE == 3 && rtcGetDeviceProperty(device, RTCDeviceProperty(35));

  Picture picture{world, width, height, pixel_positions(world.viewport[0], width),
                  pixel_positions(world.viewport[1], height), (uint8_t *)malloc(size_t(width) * height * 3)};
  memset(picture.rgb, 1, size_t(width) * height * 3);

  const char *ray_names[] = {"single", "packets8", "packets16", "streams"};
  for (bool user : {false, true})
    for (bool low : {false, true}) {
      const std::string tree = std::string(user ? "user" : "sphere") + "-" + (low ? "low" : "medium");
      if (!wanted.empty() && wanted.compare(0, tree.size() + 1, tree + "-")) continue;
      rtcReleaseScene(build(device, world, user, low)); // wakes the threads
      std::vector<double> built;
      RTCScene s = nullptr;
      for (int run = 0; run < runs; run++) {
        if (s) rtcReleaseScene(s);
        const double start = milliseconds();
        s = build(device, world, user, low);
        built.push_back(milliseconds() - start);
      }
      for (Rays rays : {Rays::single, Rays::packets8, Rays::packets16, Rays::streams}) {
        const std::string mode = tree + "-" + ray_names[int(rays)];
        if (!wanted.empty() && wanted != mode) continue;
        if (rays == Rays::streams && !streams) continue;
        std::vector<double> traced;
        for (int run = -1; run < runs; run++) {
          const double start = milliseconds();
          arena.execute([&] { trace(picture, s, rays); });
          if (run >= 0) traced.push_back(milliseconds() - start);
        }
        printf("{\"mode\": \"%s\", ", mode.c_str());
        print_samples("build", built.data(), runs);
        printf(", ");
        print_samples("trace", traced.data(), runs);
        printf("}\n");
        fflush(stdout);
        if (argc > 7) write_image(argv[7], picture.rgb, width, height);
      }
      rtcReleaseScene(s);
    }
  rtcReleaseDevice(device);
}
