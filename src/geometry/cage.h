// A subdivision mesh's topology, scheme, tags and facevarying seams as OpenSubdiv wants them. Made and used by the
// subdivision maker; holds no positions and evaluates nothing.
#pragma once
#include <opensubdiv/far/topologyRefiner.h>

#include <memory>
#include <string>
#include <vector>

#include "geometry/build.h"

namespace kinora::geometry {

struct Cage {
  // A facevarying primvar whose equal values at a vertex have been joined: what is joined is smooth, the rest is a
  // seam.
  struct FaceVarying {
    const SourcePrimvar* source = nullptr;
    std::vector<int> valueOfCorner;
    std::vector<double> values;  // unique ones, `width` each
    int width = 1;
  };
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
  std::vector<FaceVarying> faceVarying;
  std::vector<int> holes;
};

// Nothing when OpenSubdiv cannot take the faces; `why` then says so. Faces must lie within their lists. Tags that
// cannot be used are reported and left out.
std::unique_ptr<Cage> makeCage(const scene::Primitive& primitive, const scene::SubdivisionMesh& shape,
                               size_t pointCount, const std::vector<SourcePrimvar>& primvars,
                               Diagnostics& diagnostics, std::string& why);

// The faces that the tag "hole" names, within range, sorted.
std::vector<int> holesOf(const scene::SubdivisionMesh& shape);

}  // namespace kinora::geometry
