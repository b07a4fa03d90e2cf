// The primitives of the C interface.
#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <string_view>

#include "rib/ri/parameter_lists.h"

using kinora::rib::PrimvarCounts;
using kinora::rib::ri::Given;
using kinora::rib::ri::stream;
namespace scene = kinora::scene;

namespace {

std::vector<int> listOf(const RtInt* x, size_t n) { return {x, x + n}; }
size_t sum(const RtInt* x, RtInt n) { return size_t(std::max(std::accumulate(x, x + std::max(n, 0), 0L), 0L)); }
size_t count(RtInt n) { return size_t(std::max(n, 0)); }
bool is(const char* text, const char* word) { return text && std::string_view(text) == word; }

scene::Shape quadric() { return scene::Quadric{}; }

}  // namespace

extern "C" {

KINORA_RI(RiSphere, thetamax, (radius, zmin, zmax, thetamax), RtFloat radius, RtFloat zmin, RtFloat zmax,
          RtFloat thetamax) {
  stream().request("Sphere").number(radius).number(zmin).number(zmax).number(thetamax).list({n, tokens, values},
                                                                                            quadric());
}
KINORA_RI(RiCone, thetamax, (height, radius, thetamax), RtFloat height, RtFloat radius, RtFloat thetamax) {
  stream().request("Cone").number(height).number(radius).number(thetamax).list({n, tokens, values}, quadric());
}
KINORA_RI(RiCylinder, thetamax, (radius, zmin, zmax, thetamax), RtFloat radius, RtFloat zmin, RtFloat zmax,
          RtFloat thetamax) {
  stream()
      .request("Cylinder")
      .number(radius)
      .number(zmin)
      .number(zmax)
      .number(thetamax)
      .list({n, tokens, values}, quadric());
}
KINORA_RI(RiHyperboloid, thetamax, (point1, point2, thetamax), RtPoint point1, RtPoint point2, RtFloat thetamax) {
  stream().request("Hyperboloid");
  for (const RtFloat* p : {point1, point2})
    for (int k = 0; k < 3; ++k) stream().number(p[k]);
  stream().number(thetamax).list({n, tokens, values}, quadric());
}
KINORA_RI(RiParaboloid, thetamax, (rmax, zmin, zmax, thetamax), RtFloat rmax, RtFloat zmin, RtFloat zmax,
          RtFloat thetamax) {
  stream()
      .request("Paraboloid")
      .number(rmax)
      .number(zmin)
      .number(zmax)
      .number(thetamax)
      .list({n, tokens, values}, quadric());
}
KINORA_RI(RiDisk, thetamax, (height, radius, thetamax), RtFloat height, RtFloat radius, RtFloat thetamax) {
  stream().request("Disk").number(height).number(radius).number(thetamax).list({n, tokens, values}, quadric());
}
KINORA_RI(RiTorus, thetamax, (majorradius, minorradius, phimin, phimax, thetamax), RtFloat majorradius,
          RtFloat minorradius, RtFloat phimin, RtFloat phimax, RtFloat thetamax) {
  stream().request("Torus").number(majorradius).number(minorradius).number(phimin).number(phimax).number(thetamax);
  stream().list({n, tokens, values}, quadric());
}

KINORA_RI(RiPolygon, nvertices, (nvertices), RtInt nvertices) {
  stream().request("Polygon").list({n, tokens, values}, scene::PolygonMesh{{}, {nvertices}, {}});
}
KINORA_RI(RiGeneralPolygon, nverts, (nloops, nverts), RtInt nloops, RtInt nverts[]) {
  stream().request("GeneralPolygon").integers(nverts, count(nloops));
  stream().list({n, tokens, values}, scene::PolygonMesh{{nloops}, listOf(nverts, count(nloops)), {}});
}
KINORA_RI(RiPointsPolygons, verts, (npolys, nverts, verts), RtInt npolys, RtInt nverts[], RtInt verts[]) {
  const size_t corners = sum(nverts, npolys);
  stream().request("PointsPolygons").integers(nverts, count(npolys)).integers(verts, corners);
  stream().list({n, tokens, values}, scene::PolygonMesh{{}, listOf(nverts, count(npolys)), listOf(verts, corners)});
}
KINORA_RI(RiPointsGeneralPolygons, verts, (npolys, nloops, nverts, verts), RtInt npolys, RtInt nloops[],
          RtInt nverts[], RtInt verts[]) {
  const size_t loops = sum(nloops, npolys), corners = sum(nverts, RtInt(loops));
  stream().request("PointsGeneralPolygons").integers(nloops, count(npolys)).integers(nverts, loops);
  stream().integers(verts, corners);
  stream().list({n, tokens, values},
                scene::PolygonMesh{listOf(nloops, count(npolys)), listOf(nverts, loops), listOf(verts, corners)});
}
KINORA_RI(RiSubdivisionMesh, floatargs, (scheme, nfaces, nverts, verts, ntags, tags, nargs, intargs, floatargs),
          RtToken scheme, RtInt nfaces, RtInt nverts[], RtInt verts[], RtInt ntags, RtToken tags[], RtInt nargs[],
          RtInt intargs[], RtFloat floatargs[]) {
  const size_t corners = sum(nverts, nfaces);
  stream().request("SubdivisionMesh").word(scheme).integers(nverts, count(nfaces)).integers(verts, corners);
  if (ntags > 0) {
    size_t ints = 0, numbers = 0;
    for (RtInt i = 0; i < ntags; ++i) ints += count(nargs[2 * i]), numbers += count(nargs[2 * i + 1]);
    stream().words(tags, count(ntags)).integers(nargs, 2 * count(ntags)).integers(intargs, ints);
    stream().floats(floatargs, numbers);
  }
  stream().list(
      {n, tokens, values},
      scene::SubdivisionMesh{scheme ? scheme : "", listOf(nverts, count(nfaces)), listOf(verts, corners), {}});
}

KINORA_RI(RiPatch, type, (type), RtToken type) {
  stream().request("Patch").word(type).list({n, tokens, values}, scene::Patch{is(type, "bicubic")});
}
KINORA_RI(RiPatchMesh, vwrap, (type, nu, uwrap, nv, vwrap), RtToken type, RtInt nu, RtToken uwrap, RtInt nv,
          RtToken vwrap) {
  stream().request("PatchMesh").word(type).integer(nu).word(uwrap).integer(nv).word(vwrap);
  const scene::PatchMesh mesh{is(type, "bicubic"), is(uwrap, "periodic"), is(vwrap, "periodic"), nu, nv};
  stream().list({n, tokens, values}, mesh, count(nu) * count(nv));
}
KINORA_RI(RiNuPatch, vmax, (nu, uorder, uknot, umin, umax, nv, vorder, vknot, vmin, vmax), RtInt nu, RtInt uorder,
          RtFloat uknot[], RtFloat umin, RtFloat umax, RtInt nv, RtInt vorder, RtFloat vknot[], RtFloat vmin,
          RtFloat vmax) {
  stream().request("NuPatch").integer(nu).integer(uorder).floats(uknot, count(nu + uorder)).number(umin).number(umax);
  stream().integer(nv).integer(vorder).floats(vknot, count(nv + vorder)).number(vmin).number(vmax);
  scene::NuPatch patch;
  patch.nu = std::max(nu, uorder), patch.uOrder = uorder, patch.nv = std::max(nv, vorder), patch.vOrder = vorder;
  stream().list({n, tokens, values}, patch, count(nu) * count(nv));
}
RtVoid RiTrimCurve(RtInt nloops, RtInt ncurves[], RtInt order[], RtFloat knot[], RtFloat min[], RtFloat max[],
                   RtInt n[], RtFloat u[], RtFloat v[], RtFloat w[]) {
  const size_t curves = sum(ncurves, nloops);
  size_t knots = 0, points = 0;
  for (size_t i = 0; i < curves; ++i) knots += count(n[i] + order[i]), points += count(n[i]);
  stream().request("TrimCurve").integers(ncurves, count(nloops)).integers(order, curves).floats(knot, knots);
  stream().floats(min, curves).floats(max, curves).integers(n, curves);
  stream().floats(u, points).floats(v, points).floats(w, points);
}

KINORA_RI(RiCurves, wrap, (type, ncurves, nvertices, wrap), RtToken type, RtInt ncurves, RtInt nvertices[],
          RtToken wrap) {
  stream().request("Curves").word(type).integers(nvertices, count(ncurves)).word(wrap);
  const scene::Curves curves{is(type, "cubic"), is(wrap, "periodic"), listOf(nvertices, count(ncurves))};
  stream().list({n, tokens, values}, curves, sum(nvertices, ncurves));
}
KINORA_RI(RiPoints, npoints, (npoints), RtInt npoints) {
  stream().request("Points").list({n, tokens, values}, scene::Points{npoints}, count(npoints));
}
KINORA_RI(RiBlobby, strings, (nleaf, ncode, code, nfloats, floats, nstrings, strings), RtInt nleaf, RtInt ncode,
          RtInt code[], RtInt nfloats, RtFloat floats[], RtInt nstrings, RtToken strings[]) {
  stream().request("Blobby").integer(nleaf).integers(code, count(ncode)).floats(floats, count(nfloats));
  stream().words(strings, count(nstrings));
  const size_t leaves = count(nleaf);
  stream().list({n, tokens, values}, PrimvarCounts{1, leaves, leaves, leaves, 0});
}
KINORA_RI(RiVolume, nvertices, (type, bound, nvertices), RtToken type, RtBound bound, RtInt nvertices[3]) {
  stream().request("Volume").word(type).floats(bound, 6).integers(nvertices, 3);
  const size_t points = count(nvertices[0]) * count(nvertices[1]) * count(nvertices[2]);
  stream().list({n, tokens, values}, PrimvarCounts{1, points, points, points, 0});
}
KINORA_RI(RiGeometry, type, (type), RtToken type) {
  stream().request("Geometry").word(type).list({n, tokens, values});
}

RtVoid RiProcDelayedReadArchive(RtPointer, RtFloat) {}
RtVoid RiProcRunProgram(RtPointer, RtFloat) {}
RtVoid RiProcDynamicLoad(RtPointer, RtFloat) {}
RtVoid RiProcFree(RtPointer data) { std::free(data); }

RtVoid RiProcedural(RtPointer data, RtBound bound, RtProcSubdivFunc subdivide, RtProcFreeFunc release) {
  const struct {
    RtProcSubdivFunc function;
    const char* name;
    size_t words;
  } kStandard[] = {{RiProcDelayedReadArchive, "DelayedReadArchive", 1},
                   {RiProcRunProgram, "RunProgram", 2},
                   {RiProcDynamicLoad, "DynamicLoad", 2}};
  bool isStandard = false;
  for (const auto& s : kStandard)
    if (subdivide == s.function) {
      stream().request("Procedural").word(s.name).words(static_cast<const RtToken*>(data), s.words).floats(bound, 6);
      isStandard = true;
    }
  if (!isStandard && subdivide)
    if (const auto detail = stream().enterProcedural(bound)) {
      RiAttributeBegin();
      subdivide(data, RtFloat(*detail));
      RiAttributeEnd();
      stream().leaveProcedural();
    }
  if (release) release(data);
}

}  // extern "C"
