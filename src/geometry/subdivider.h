// One subdivision mesh on its way to triangles: the surfaces of its faces, the rates of its edges, the cells that faces are
// cut into, and the vertices that they share. Made and run by subdivision.cpp; the rates are chosen in
// subdivision_rates.cpp.
#pragma once
#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/tessellation.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "geometry/build.h"
#include "geometry/cage.h"
#include "geometry/dice.h"
#include "geometry/refined_face.h"

namespace kinora::geometry {

class Subdivider {
 public:
  Subdivider(const scene::Primitive& primitive, const PointKeys& points, const Cage& cage, const DiceRate& rate,
             Diagnostics& diagnostics, Mesh& mesh)
      : primitive_(primitive),
        cage_(cage),
        level_(cage.refiner->GetLevel(0)),
        factory_(*cage.refiner),
        unshared_(*cage.refiner, OpenSubdiv::Bfr::SurfaceFactory::Options().EnableCaching(false)),
        rate_(rate),
        diagnostics_(diagnostics),
        mesh_(mesh),
        displaced_(rate.isDisplaced) {
    for (const auto& key : points.keys) keys_.emplace_back(key.begin(), key.end());
    keyPatch_.resize(keys_.size());
    outPoints_.resize(keys_.size());
    outNormals_.resize(keys_.size());
  }

  bool run(const std::vector<SourcePrimvar>& primvars);

 private:
  using Surface = OpenSubdiv::Bfr::Surface<double>;
  // Interpolated data of one kind, with the surface of the current face.
  struct Channel {
    enum class Kind { Vertex, Varying, FaceVarying } kind = Kind::Vertex;
    int index = 0;  // of the facevarying channel
    int width = 0;
    std::vector<double> data;                                 // control values
    std::vector<std::pair<const SourcePrimvar*, int>> parts;  // which primvars, and where in the values of a vertex
    Surface surface;
    std::vector<double> patch;
  };
  // A point of a cell's outline: on the cage (shared between faces) or inside the face (shared between its cells).
  struct Site {
    int64_t shared = -1;
    int inFace = -1;
  };
  void addChannels(const std::vector<SourcePrimvar>& primvars);
  void chooseRates();
  void rateFace(int face, std::vector<double>& wanted);
  void ratePlace(int face, double edge, std::vector<double>& wanted);
  double estimate() const;
  bool isSplit(int face) const {  // into sub-faces
    const int n = level_.GetFaceVertices(face).size();
    return factory_.GetSchemeType() != OpenSubdiv::Sdc::SCHEME_LOOP && n != 4;
  }
  bool start(int face);
  bool isWhole(int face) const {  // not cut at all
    const auto edges = level_.GetFaceEdges(face);
    return std::all_of(edges.begin(), edges.end(), [&](int e) { return rates_[e] == 1; });
  }
  void preparePoints(size_t key);
  void prepare(int face, bool valuesOnly = false);
  void evaluate(const double uv[2]);
  void evaluateValues(const double uv[2]);
  uint32_t emit(Site site);
  void makeFace(int face);
  void makeCell(int face, const OpenSubdiv::Bfr::Parameterization& pattern, int rateCount, const int* rates,
                const std::vector<Site>& outline, int subFace);
  Site onEdge(int face, int k, int step) const;  // step along edge k in the face's direction

  void emitFacet(int face, const int* facet, int corners);

  Imath::V3d position(size_t key, const double uv[2], Imath::V3d& normal) const;

  const scene::Primitive& primitive_;
  const Cage& cage_;
  const OpenSubdiv::Far::TopologyLevel& level_;
  OpenSubdiv::Bfr::RefinerSurfaceFactory<> factory_,
      unshared_;  // the latter keeps no patch for others of like topology
  const DiceRate& rate_;
  Diagnostics& diagnostics_;
  Mesh& mesh_;
  const bool displaced_;

  std::vector<std::vector<double>> keys_;  // control points
  Surface surface_;
  std::unique_ptr<RefinedFace> refined_;  // instead of all surfaces of the current face; keys first, then channels
  OpenSubdiv::Bfr::Parameterization parameterization_;  // of the current face
  std::vector<std::vector<double>> keyPatch_;
  std::vector<Channel> channels_;
  int valueWidth_ = 0;

  std::vector<int> rates_;           // segments an edge
  bool allWhole_ = false;            // every face is a quad that is not cut
  std::vector<int64_t> edgeOffset_;  // first shared id of an edge's inner points
  std::vector<uint32_t> firstAt_;    // shared id -> mesh vertex, kNone before
  std::vector<uint32_t> nextAt_;     // mesh vertex -> another one at the same place
  std::vector<uint32_t> inFace_;     // of the current face
  static constexpr uint32_t kNone = ~0u;

  std::vector<Imath::V3d> samplePoint_, sampleNormal_;  // a key
  std::vector<double> sampleValues_;
  std::vector<std::vector<Imath::V3d>> outPoints_, outNormals_;
  std::vector<float> outValues_;             // valueWidth_ a vertex
  std::vector<double> coords_, valueRange_;  // largest minus least control value, by value of a vertex
  std::vector<int> facets_;
  std::vector<uint32_t> cellVertex_;
};

}  // namespace kinora::geometry
