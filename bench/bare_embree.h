// Bare Embree on recorded rays: the same triangles or curves in a scene of its own, the same device string and kind
// of BVH, and for each kind of ray (camera, indirect by depth, shadow by depth) the fastest of Embree's calls. It
// shades nothing.
#pragma once
#include <embree3/rtcore.h>

#include <array>
#include <map>
#include <string>

#include "recorded_rays.h"
#include "rich_scene.h"
#include "scenes.h"

namespace kinora::bench {

enum class Call { One, Four, Eight, Sixteen, StreamOfRays, StreamOfArrays, Count };
const char* nameOf(Call call);

class BareEmbree {
 public:
  explicit BareEmbree(const TriangleMesh& mesh);
  explicit BareEmbree(const CurveSet& curves);  // round Bezier curves
  // What is placed once and stands still lies in the top level as it is; all else is an instance of a scene.
  explicit BareEmbree(const RichScene& rich);
  ~BareEmbree();
  BareEmbree(const BareEmbree&) = delete;
  // Tries every call on all the rays, `rounds` times in turn, and keeps for each kind the one with the least time.
  void chooseCalls(const RecordedRays& rays, int rounds);
  // Seconds by the calls chosen. Timed for each batch on its own, the batch in the cache as it is in a renderer's
  // group: SoA calls pack their rays from arrays and copy hits back; single rays and streams of rays find theirs
  // packed.
  struct Seconds {
    double camera = 0, indirect = 0, shadow = 0;
    double sum() const { return camera + indirect + shadow; }
  };
  Seconds replay(const RecordedRays& rays);
  // Of the last replay.
  uint64_t hits(bool shadow) const { return hits_[shadow]; }
  std::string choice() const;  // "camera: 16, indirect 1: 1, ..."

 private:
  using Kind = std::pair<bool, uint32_t>;  // shadow, depth
  BareEmbree();
  void attach(RTCGeometry g, RTCScene to);
  void attachMesh(const TriangleMesh& mesh, const std::vector<float>& later, RTCScene to);
  double trace(const RecordedRays& rays, const RayBatch& batch, Call call);
  RTCDevice device_;
  RTCScene scene_;
  std::vector<RTCScene> parts_;
  std::map<Kind, Call> choice_;
  uint64_t hits_[2] = {0, 0};
  struct Buffers;
  Buffers* buffers_;
};

}  // namespace kinora::bench
