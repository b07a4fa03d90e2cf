// The interface of a projection: the ray of a sample, and the way back from a point to the raster (for light paths).
// Camera space: left-handed, +x right, +y up, +z into the scene, eye at the origin; units of the scene.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

struct ProjectionInfo {   // CreateInfo::extra
  float screenWindow[4];  // left right bottom top, on the plane at distance 1 for perspective with fov 90
  int screenWindowGiven;  // 0: the default for the frame's aspect ratio
  float frameAspect;      // width / height of the picture, pixel aspect included
  uint32_t resolution[2];
  float fStop, focalLength, focalDistance;  // DepthOfField request; fStop 0: pinhole
  float clipping[2];                        // near, far along z; 0 0: none
  // Shape of the lens; sides below 3: a circle. Degrees from +x to a corner; -1 to 1, 0 straight sides, 1 a circle,
  // below 0 bowed in; -1 to 1, above 0 brighter at the rim; height over width, 0 counts as 1.
  float apertureSides, apertureAngle, apertureRoundness, apertureDensity, apertureAspect;
  double worldToCamera[16];  // at the middle of the shutter; row-major, for row vectors; all 0: not known
};

struct CameraSampleArgs {
  uint32_t count;
  const float* raster[2];  // pixels, origin at the top left corner, y down
  const float* lens[2];    // in [0, 1)
  const float* time;       // 0..1 over the shutter
  float* o[3];             // out, camera space
  float* d[3];             // out, unit
  float* weight;           // out: importance over pdf; 1 for plain cameras
  float* radius;           // out: footprint radius at the origin
  float* spread;           // out: growth of the radius per unit distance: half a pixel's angle
};

struct CameraConnectArgs {
  uint32_t count;
  const float* P[3];  // camera space
  const float* lens[2];
  const float* time;
  float* o[3];        // out: point on the lens
  float* raster[2];   // out: pixels
  float* importance;  // out: of the pixel-normalised sensor: We such that the mean over a pixel's
                      // samples of L * (path of the camera) equals the sum of splats, each f(P) * importance *
                      // |cosine at P| / distance^2; the cosine at the lens is in it. 0: not seen
  float* pdf;         // out: per solid angle at the lens point, of rays() making this direction
};

struct ProjectionFunctions {
  void (*rays)(const void* projection, const CameraSampleArgs*);
  void (*connect)(const void* projection, const CameraConnectArgs*);
};

// A shutter that opens line by line of the picture, not everywhere at once.
struct ShutterSweep {
  uint32_t columns = 0;   // 1: lines are columns of pixels, 0: rows
  uint32_t backward = 0;  // 0: the first ones are the left or the upper ones
  float duration = 1;     // of the shutter's time that a line is open for; the last one's ends with the shutter's
};

struct ProjectionTraits {
  // Camera space to NDC at the middle of the shutter, for metadata (row vectors, row-major): x and y over w run from
  // (0, 0) at the picture's upper left corner to (1, 1) at its lower right one; z grows with depth. May be null.
  void (*ndcMatrix)(const void* projection, double out[16]);
  void (*sweep)(const void* projection, ShutterSweep* out) = nullptr;  // null: the shutter opens everywhere at once
};

// What a projection declares.
struct ProjectionPlugin {
  using Functions = ProjectionFunctions;
  static constexpr Kind kKind = Kind::Projection;
  const char* help = "";
  ListOf<Param> params = {};
  SetUp setUp = {};
  void (*ndcMatrix)(const void* projection, double out[16]) = nullptr;
  void (*sweep)(const void* projection, ShutterSweep* out) = nullptr;
  constexpr ProjectionTraits traits() const { return {ndcMatrix, sweep}; }
};

}  // namespace kinora
