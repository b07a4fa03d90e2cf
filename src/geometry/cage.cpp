#include "geometry/cage.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

namespace kinora::geometry {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

namespace {

// OpenSubdiv reports through two process-wide functions and prints to standard error by default.
thread_local std::string lastComplaint;
void keepError(Far::ErrorType, const char* message) { lastComplaint = message; }
void keepWarning(const char* message) { lastComplaint = message; }
void catchComplaints() {
  static std::once_flag once;
  std::call_once(once, [] {
    Far::SetErrorCallback(keepError);
    Far::SetWarningCallback(keepWarning);
  });
  lastComplaint.clear();
}

// What the tags say, ready for the descriptor.
struct Tags {
  Sdc::Options options;
  std::vector<int> creasePairs, corners, holes;
  std::vector<float> creaseWeights, cornerWeights;
};

Tags readTags(const scene::Primitive& primitive, const scene::SubdivisionMesh& shape, size_t pointCount,
              Diagnostics& diagnostics) {
  Tags out;
  out.options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_NONE);
  int faceVaryingMode = 1, propagate = 0;
  std::map<std::string, int> unknown;
  auto complain = [&](const std::string& what) {
    diagnostics.warning("GEOM-TAG", primitive.pos, subject(primitive) + ": " + what,
                        "that part of the tag is left out");
  };
  auto vertexExists = [&](int v) { return v >= 0 && size_t(v) < pointCount; };
  // Sharpness k of n, where one value may stand for all. Not a number is no sharpness.
  auto sharpness = [](const std::vector<float>& floats, size_t k) {
    const float s = floats.size() == 1 ? floats[0] : k < floats.size() ? floats[k] : 0.f;
    return s > 0 ? std::min(s, 10.f) : 0.f;  // 10 and more: infinitely sharp
  };
  for (const auto& tag : shape.tags) {
    const int first = tag.ints.empty() ? 1 : tag.ints[0];
    if (tag.name == "interpolateboundary") {
      out.options.SetVtxBoundaryInterpolation(first == 0   ? Sdc::Options::VTX_BOUNDARY_NONE
                                              : first == 2 ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                                           : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    } else if (tag.name == "facevaryinginterpolateboundary") {
      faceVaryingMode = first;
    } else if (tag.name == "facevaryingpropagatecorners") {
      propagate = first;
    } else if (tag.name == "crease") {
      const size_t edges = tag.ints.size() < 2 ? 0 : tag.ints.size() - 1;
      if (edges == 0 || (tag.floats.size() != 1 && tag.floats.size() < edges))
        complain("a crease of " + std::to_string(tag.ints.size()) + " vertices with " +
                 std::to_string(tag.floats.size()) + " sharpnesses");
      for (size_t k = 0; k < edges; ++k) {
        if (!vertexExists(tag.ints[k]) || !vertexExists(tag.ints[k + 1])) {
          complain("a crease names a vertex that is not there");
          continue;
        }
        out.creasePairs.insert(out.creasePairs.end(), {tag.ints[k], tag.ints[k + 1]});
        out.creaseWeights.push_back(sharpness(tag.floats, k));
      }
    } else if (tag.name == "corner") {
      for (size_t k = 0; k < tag.ints.size(); ++k) {
        if (!vertexExists(tag.ints[k])) {
          complain("a corner names a vertex that is not there");
          continue;
        }
        out.corners.push_back(tag.ints[k]);
        out.cornerWeights.push_back(sharpness(tag.floats, k));
      }
    } else if (tag.name == "hole") {
      for (int f : tag.ints)
        if (f < 0 || size_t(f) >= shape.verticesPerFace.size()) complain("a hole names a face that is not there");
    } else if (tag.name == "creasemethod") {
      const bool chaikin = !tag.strings.empty() && tag.strings[0] == "chaikin";
      out.options.SetCreasingMethod(chaikin ? Sdc::Options::CREASE_CHAIKIN : Sdc::Options::CREASE_UNIFORM);
    } else if (tag.name == "smoothtriangles") {
      out.options.SetTriangleSubdivision(first ? Sdc::Options::TRI_SUB_SMOOTH : Sdc::Options::TRI_SUB_CATMARK);
    } else {
      ++unknown[tag.name];
    }
  }
  if (!unknown.empty()) {
    // edits of a hierarchical mesh come by the hundred
    std::string names;
    for (const auto& [name, count] : unknown) {
      if (names.size() > 100) {
        names += " ...";
        break;
      }
      names += (names.empty() ? "'" : ", '") + name.substr(0, 40) + "'";
      if (count > 1) names += " (" + std::to_string(count) + " times)";
    }
    diagnostics.warning("GEOM-TAG", primitive.pos, subject(primitive) + ": tags that are not supported: " + names,
                        "its surface without them is rendered");
  }
  out.options.SetFVarLinearInterpolation(faceVaryingMode == 0   ? Sdc::Options::FVAR_LINEAR_ALL
                                         : faceVaryingMode == 2 ? Sdc::Options::FVAR_LINEAR_NONE
                                         : faceVaryingMode == 3 ? Sdc::Options::FVAR_LINEAR_BOUNDARIES
                                         : propagate            ? Sdc::Options::FVAR_LINEAR_CORNERS_PLUS2
                                                                : Sdc::Options::FVAR_LINEAR_CORNERS_PLUS1);
  out.holes = holesOf(shape);
  return out;
}

// Joins equal values at each vertex.
Cage::FaceVarying weld(const SourcePrimvar& source, const std::vector<int>& vertices, size_t pointCount) {
  Cage::FaceVarying out;
  out.source = &source;
  out.width = int(source.parameter->elementFloats());
  const size_t corners = source.elements, width = size_t(out.width);
  std::vector<int> head(pointCount, -1), next;
  out.valueOfCorner.resize(corners);
  for (size_t c = 0; c < corners; ++c) {
    const float* v = source.values.data() + c * width;
    int found = head[vertices[c]];
    while (found >= 0 && !std::equal(v, v + width, out.values.begin() + std::ptrdiff_t(found * width)))
      found = next[found];
    if (found < 0) {
      found = int(next.size());
      next.push_back(head[vertices[c]]);
      head[vertices[c]] = found;
      out.values.insert(out.values.end(), v, v + width);
    }
    out.valueOfCorner[c] = found;
  }
  return out;
}

}  // namespace

std::vector<int> holesOf(const scene::SubdivisionMesh& shape) {
  std::vector<int> out;
  for (const auto& tag : shape.tags)
    if (tag.name == "hole")
      for (int f : tag.ints)
        if (f >= 0 && size_t(f) < shape.verticesPerFace.size()) out.push_back(f);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::unique_ptr<Cage> makeCage(const scene::Primitive& primitive, const scene::SubdivisionMesh& shape,
                               size_t pointCount, const std::vector<SourcePrimvar>& primvars,
                               Diagnostics& diagnostics, std::string& why) {
  Sdc::SchemeType scheme;
  if (shape.scheme == "catmull-clark") {
    scheme = Sdc::SCHEME_CATMARK;
  } else if (shape.scheme == "loop") {
    scheme = Sdc::SCHEME_LOOP;
  } else if (shape.scheme == "bilinear") {
    scheme = Sdc::SCHEME_BILINEAR;
  } else {
    why = "its scheme \"" + shape.scheme + "\" is unknown";
    return nullptr;
  }
  size_t corners = 0;
  for (int n : shape.verticesPerFace) {
    if (n < 3 || (n != 3 && scheme == Sdc::SCHEME_LOOP) || n > 65535) {
      why = "a face has " + std::to_string(n) + " vertices";
      return nullptr;
    }
    for (int k = 0; k < n; ++k) {
      const int v = shape.vertices[corners + k];
      if (v < 0 || size_t(v) >= pointCount) {
        why = "a face names vertex " + std::to_string(v) + " of " + std::to_string(pointCount);
        return nullptr;
      }
      if (v == shape.vertices[corners + (k + 1) % n]) {
        why = "a face names vertex " + std::to_string(v) + " twice in a row";
        return nullptr;
      }
    }
    corners += size_t(n);
  }

  auto cage = std::make_unique<Cage>();
  const Tags tags = readTags(primitive, shape, pointCount, diagnostics);
  cage->holes = tags.holes;
  for (const SourcePrimvar& s : primvars)
    if (s.storage == scene::StorageClass::FaceVarying || s.storage == scene::StorageClass::FaceVertex)
      cage->faceVarying.push_back(weld(s, shape.vertices, pointCount));

  Far::TopologyDescriptor d;
  d.numVertices = int(pointCount);
  d.numFaces = int(shape.verticesPerFace.size());
  d.numVertsPerFace = shape.verticesPerFace.data();
  d.vertIndicesPerFace = shape.vertices.data();
  d.numCreases = int(tags.creaseWeights.size());
  d.creaseVertexIndexPairs = tags.creasePairs.data();
  d.creaseWeights = tags.creaseWeights.data();
  d.numCorners = int(tags.corners.size());
  d.cornerVertexIndices = tags.corners.data();
  d.cornerWeights = tags.cornerWeights.data();
  d.numHoles = int(tags.holes.size());
  d.holeIndices = tags.holes.data();
  std::vector<Far::TopologyDescriptor::FVarChannel> channels(cage->faceVarying.size());
  for (size_t i = 0; i < channels.size(); ++i) {
    const Cage::FaceVarying& f = cage->faceVarying[i];
    channels[i].numValues = int(f.values.size() / f.width);
    channels[i].valueIndices = f.valueOfCorner.data();
  }
  d.numFVarChannels = int(channels.size());
  d.fvarChannels = channels.data();

  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  catchComplaints();
  cage->refiner.reset(Factory::Create(d, Factory::Options(scheme, tags.options)));
  if (!cage->refiner) {
    why = lastComplaint.empty() ? "its topology cannot be subdivided" : lastComplaint;
    std::replace(why.begin(), why.end(), '\n', ' ');
    return nullptr;
  }
  const Far::TopologyLevel& level = cage->refiner->GetLevel(0);
  for (size_t i = 0; i < tags.creasePairs.size(); i += 2)
    if (level.FindEdge(tags.creasePairs[i], tags.creasePairs[i + 1]) < 0) {
      diagnostics.warning("GEOM-TAG", primitive.pos,
                          subject(primitive) + ": a crease runs from vertex " + std::to_string(tags.creasePairs[i]) +
                              " to " + std::to_string(tags.creasePairs[i + 1]) + " where there is no edge",
                          "that part of the tag is left out");
      break;
    }
  return cage;
}

}  // namespace kinora::geometry
