// The limit surface over a face of a subdivision cage whose patch OpenSubdiv 3.5 (Bfr) cannot build. Two faces that
// share two edges fold over each other around the vertex between them, which has no other face; where a sharp edge or
// a boundary is near, Bfr reads indices that it has not set. The face is refined by itself, with the ring of faces
// around it, until only the last bit at such a vertex is left. Used by the subdivision maker.
#pragma once
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <memory>
#include <vector>

namespace kinora::geometry {

// Whether a vertex of the face has this face and one other around it, joined by both edges there. Patches of such
// faces depend on which vertices are the same, so that none may be taken for another of like topology.
bool foldsAtCorner(const OpenSubdiv::Far::TopologyLevel& level, int face);
// Whether Bfr cannot build the patches of the face, for points or for a facevarying channel.
bool needsRefinement(const OpenSubdiv::Far::TopologyRefiner& refiner, int face);

// Values on the control cage.
struct CageValues {
  enum class Kind { Vertex, Varying, FaceVarying } kind = Kind::Vertex;
  int channel = 0;  // of a facevarying kind
  int width = 0;
  const double* values = nullptr;  // `width` for each vertex, or each value of the channel
};

class RefinedFace {
 public:
  // `levels`: of refinement at most; the limits at the corners of the pieces that are left are mixed bilinearly.
  // `refiner` holds no level but the cage; its scheme is not bilinear.
  RefinedFace(const OpenSubdiv::Far::TopologyRefiner& refiner, int face, const std::vector<CageValues>& values,
              int levels = 7);
  ~RefinedFace();
  // At (u, v) of Bfr's parameterization of the face: values number `which`, and their derivatives by the parameters of
  // the piece that the place is in: like those of the face but for a common positive factor. Null: not wanted.
  void evaluate(const double uv[2], size_t which, double* value, double* du = nullptr, double* dv = nullptr) const;

 private:
  struct Piece;
  std::unique_ptr<Piece> whole_;
};

}  // namespace kinora::geometry
