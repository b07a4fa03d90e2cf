#include "geometry/tessellate.h"

namespace kinora::geometry {

namespace {

constexpr Explanation kExplanations[] = {
    {"GEOM-CURVE-COUNT",
     "The number of vertices of a curve does not fit its kind: a linear curve needs 2 (3 when periodic), a cubic one "
     "4 "
     "and then a whole number of steps of its basis (periodic: a whole number of steps). Such curves are left out, "
     "the "
     "others of the primitive are rendered. See Basis; its default is bezier with step 3."},
    {"GEOM-CURVE-LENGTH",
     "Some curves have no length: all their vertices are in one place. They are left out, the others are rendered."},
    {"GEOM-FACE-AREA",
     "A face with five or more corners, or with holes, has no area: its corners lie on a line or in one point. It is "
     "left out. The rest of the mesh is rendered."},
    {"GEOM-FACE-CORNERS",
     "A face has fewer than three corners, or a polygon has no outer loop. It is left out; the rest is rendered."},
    {"GEOM-FACE-LIST",
     "The arrays that describe the faces do not fit together: a face asks for more loops or vertices than are left, "
     "or "
     "for a negative number of them. What follows cannot be trusted any more, so the faces before it are kept and "
     "the "
     "others left out. Often the file was cut or an exporter counted wrongly."},
    {"GEOM-FACE-TANGLED",
     "The outline of a polygon crosses itself, or one of its holes lies outside of it or touches its side. What the "
     "outline goes round is covered, in whatever direction and however often it does (a pentagram with its middle, "
     "both halves of a bow tie), but for what holes go round, all facing the same way. Points are added where it "
     "crosses itself, with values between those of the corners. Outlines of more than 512 corners, or very many "
     "crossings, are covered by triangles of their corners as well as these can."},
    {"GEOM-INDEX-RANGE",
     "A face names a vertex that is not among the points: its number is negative or too large. The face is left "
     "out."},
    {"GEOM-MOTION-MISMATCH",
     "The keys of a MotionBegin block do not describe one moving object: they have different numbers of points, or "
     "their "
     "times do not increase, or one of them cannot be used by itself. The object is rendered still, as its first key "
     "says."},
    {"GEOM-NO-POINTS", "A primitive that is made of points has no P (nor Pw), or an empty one. It is left out."},
    {"GEOM-NORMAL",
     "Some normals (N) are zero or not finite. The normals of the triangles around them are used instead."},
    {"GEOM-NORMALS-TURNED",
     "Most of the normals (N) that a mesh carries point to the side that its orientation calls the back. Shading "
     "with "
     "them would darken the whole object, so they are turned to the front. If light seems to come from inside, the "
     "orientation is wrong instead: see Orientation and ReverseOrientation."},
    {"GEOM-NOT-FINITE",
     "A number of a primitive is not a number or infinite. Faces of a polygon mesh with such a corner are left out, "
     "a "
     "subdivision mesh becomes polygons without them, any other primitive is left out as a whole."},
    {"GEOM-BLOBBY",
     "The instructions of a Blobby cannot be followed: a code that is not known, a number or an operand that is not "
     "there, "
     "a leaf count that does not fit; it is left out. Or a leaf of it is of a kind that is not rendered (a repelling "
     "plane, a field plug-in) or has no volume; that leaf counts as nothing."},
    {"GEOM-NOT-RENDERED-YET-",
     "This kind of primitive is read and kept in the scene but Kinora does not render it yet. It is left out of the "
     "picture."},
    {"GEOM-PATCH-SHAPE",
     "A patch, patch mesh or NURBS surface cannot be built from its numbers: too few points for its size, a size "
     "that "
     "its basis step does not divide, knots that decrease or are too few, or an empty parameter range. It is left "
     "out."},
    {"GEOM-PRIMVAR",
     "A primitive variable cannot be used on geometry: it has no values, refers to a pattern, or holds strings where "
     "interpolation would be needed. It is left out; patterns that ask for it get their default."},
    {"GEOM-PRIMVAR-COUNT",
     "A primitive variable has another number of values than its class asks for on this primitive. Where the count "
     "fits "
     "another class exactly it is taken as that one, surplus values are ignored, and with too few it is left out."},
    {"GEOM-SUBDIVISION-CAGE",
     "A subdivision mesh cannot be subdivided: its faces are broken, a point is not finite, a Loop mesh has faces "
     "that "
     "are not triangles, or its topology is refused. Its cage is rendered as polygons with smooth normals, without "
     "the "
     "parts that are broken."},
    {"GEOM-TAG",
     "A tag of a subdivision mesh names vertices, edges or faces that are not there, has the wrong number of "
     "arguments, "
     "or is of a kind that is not supported (hierarchical edits). That part of the tag is ignored."},
    {"GEOM-TOO-LARGE",
     "A single primitive has more faces than its triangles could be numbered. Cut it into several primitives."},
    {"GEOM-SHAPE-NAME",
     "Geometry \"name\" asks for a shape by its name. Known are teapot, cube (or box), sphere, cylinder, disk and "
     "plane; spheres, cylinders and disks take a radius (.5). The names of lights' shapes (rectlight, envsphere ...) "
     "mean "
     "something only where a light is declared for them. Anything else is left out."},
    {"GEOM-TRIM",
     "Trim curves of a NURBS surface cannot be used: counts that do not fit together, knots that decrease, weights "
     "of "
     "0, "
     "an order outside 2 to 64, or more segments than can be followed. A loop with such a curve is left out; where "
     "all "
     "of them are meant the surface is rendered whole."},
    {"GEOM-TRIM-CROSSING",
     "A trim loop of a NURBS surface crosses itself or another one. A point is inside where a ray from it meets the "
     "loops an odd number of times, so that what two loops have in common is outside."},
    {"GEOM-TRIM-OPEN",
     "A trim loop of a NURBS surface does not end where it begins, or its curves do not meet. A straight line closes "
     "the "
     "gap. Gaps below a thousandth of the surface are closed without a message."},
    {"GEOM-POINTS-TYPE",
     "Points are rendered as discs that face the ray (type \"particle\", the default), as discs that stand as N says "
     "or "
     "face the ray without N (\"disk\", \"patch\") or as spheres (\"sphere\", \"blobby\"). Another type was named, "
     "or one "
     "that has a stand-in only."},
    {"GEOM-POINTS-FALLOFF",
     "Points are given a falloffpower, which lets their opacity fade towards their edges. It is not rendered yet: "
     "points are as opaque at their edges as in their middles."},
    {"GEOM-WIDTH",
     "Some widths (width, constantwidth) are negative, not a number or infinite. A negative one counts as 0 where it "
     "stands: the point is absent; the curve tapers to nothing at that control point and is absent between two such, "
     "though the width that runs from a negative value to a positive one would be above 0 on a shorter piece. A "
     "width "
     "that is no finite number is replaced by the first good one, or 1."},
    {"GEOM-VOLUME",
     "A Volume request names a shape that is not known, or its bound (from and to along x, y and z) holds no space. "
     "It "
     "is taken for a box, or left out."},
    {"GEOM-ZERO-AREA",
     "Nothing of a primitive would be visible: a radius or sweep is zero, all faces are degenerate, or (for "
     "subdivision "
     "meshes) all faces are holes or lie at a boundary that is not interpolated. It is left out."},
};

}  // namespace

std::span<const Explanation> explanations() { return kExplanations; }

}  // namespace kinora::geometry
