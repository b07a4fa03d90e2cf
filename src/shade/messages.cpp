#include "shade/messages.h"

namespace kinora::shade {

namespace {

constexpr Explanation kExplanations[] = {
    {"BXDF-LAYERS",
     "A material is a tree of bxdfs (LamaSurface, LamaLayer, LamaMix, LamaAdd) that cannot be kept as it is: it has "
     "more than eight leaves (four with hair), a leaf is no Lama slab, hair stands beside other slabs than "
     "LamaDiffuse, LamaTranslucent and coats of LamaDielectric, nothing is connected, the back differs from the "
     "front, or a "
     "structure written by hand is no tree. The "
     "message says what is done. `kinora plugins LamaSurface` has the rules."},
    {"SHADER-COMPILE",
     "A file of the shading language was found for a pattern and cannot be compiled, or it is compiled by a version "
     "or a tool "
     "whose text is not understood; the errors follow with file, line and column. What the shader feeds is magenta "
     "where it is "
     "a colour and has its default elsewhere. `kinora shader compile FILE` says the same without rendering."},
    {"PATTERN-PRIMSTR",
     "The name of a file in a material holds the token <primstr:NAME>, which stands for the constant string primvar "
     "NAME of "
     "each object, and an object with that material has none. The token stays in the name, and the file is mostly "
     "not found."},
    {"PATTERN-RAMP",
     "The ramp of a pattern has more knots than colours or fewer, or knots that do not ascend. Knots and colours go "
     "together by number; what is left over is not used, and a knot that lies before the one ahead of it ends no "
     "piece of the ramp."},
    {"PATTERN-COORDSYS",
     "A pattern, material or displacement has a parameter that names a coordinate system, and nothing in the scene "
     "gives "
     "that name: no CoordinateSystem or ScopedCoordinateSystem in the world, none in the definition of an object. "
     "What it "
     "computes stays in the world's space. Names are case-sensitive."},
    {"PATTERN-EXPRESSION",
     "The expression of a PxrSeExpr node is not understood; the message says what is wrong, with line and column "
     "within "
     "the expression. It is assignments (name = value;) and conditions (if (...) { ... } else { ... }), then the "
     "result "
     "without a name. What the node feeds is magenta where it is a colour and has its default elsewhere. "
     "`kinora plugins PxrSeExpr` lists the variables."},
    {"SHADER-OSO",
     "A compiled shader (.oso) was found and cannot be used: it is damaged, of a version that is not known, or made "
     "by "
     "a tool "
     "whose text is not understood; the message says where. The source of the same name stands beside it and is "
     "compiled "
     "in its place, so that the picture is as it should be. Removing the .oso file, or writing it again with `kinora "
     "shader compile`, ends the message."},
    {"SHADER-CALL",
     "A shader calls something that this renderer does not grant: trace(), because integrators do not let shaders "
     "trace rays. "
     "The call answers as if nothing were there. The message stands once for each kind of call."},
    {"SHADER-COORDSYS",
     "A shader transforms to or from a coordinate system by a name that nothing in the scene gives: no "
     "CoordinateSystem, "
     "no object that is being shaded. What it transforms stays as it is, and getmatrix() returns 0. Names are told "
     "once "
     "each."},
    {"SHADER-DICTIONARY",
     "dict_find() of a shader was given a text that is no XML or a query that is no XPath; the message says what is "
     "wrong. "
     "Nothing is found in it."},
    {"SHADER-CLOSURE",
     "A shader makes closures (diffuse(), emission() ...), as surface shaders of other renderers do. Here shaders "
     "are patterns: "
     "they compute colours and numbers, and a Bxdf scatters the light. The closure has no value and Ci no effect; "
     "connect the "
     "shader's other outputs to a Bxdf."},
    {"SHADER-RECOMPILED",
     "The scene was edited, and a file of a shader has changed since it was compiled (the shader's own, or one that "
     "it "
     "includes): the new text is what is rendered from now on."},
    {"SHADER-CACHE",
     "Option \"shader\" \"int cache\" [1] asks for compiled shaders beside their sources (NAME.oso beside NAME.osl), "
     "and that "
     "folder cannot be written. Rendering does not need it: shaders are compiled in memory, in milliseconds."},
    {"SHADER-GROUP",
     "Shaders that feed each other cannot run as one program: a connection between types that do not fit, a cycle, "
     "or an "
     "operation that this renderer refuses. What they feed uses its defaults."},
    {"SHADER-OUTPUT",
     "A string, a matrix or an array of a shader is connected to a parameter of a plug-in, which takes numbers, "
     "colours, "
     "points, vectors and normals. The parameter's default is used."},
    {"SHADER-ERROR", "A shader called error(). The text is its own; rendering goes on with what it computes."},
    {"SHADER-WARNING",
     "A shader called warning(), or an index ran out of an array and was clamped. The text says which."},
    {"SHADER-PRINT", "A shader called printf()."},
    {"PARAM-UNKNOWN",
     "A node is given a parameter that its plug-in does not have; it is ignored. `kinora plugins NAME` lists those "
     "it "
     "has. Often a misspelling, or a parameter of a newer or older version of the plug-in of that name."},
    {"PARAM-TYPE", "A parameter's value has another type or length than its plug-in declares. The default is used."},
    {"PARAM-IMAGE", "A plug-in is told to show an image and is given no name of one. The message says what is seen."},
    {"PARAM-NO-EFFECT",
     "A plug-in takes a parameter so that scenes are read, and does nothing with it; the scene sets it to something "
     "other than its default. `kinora plugins NAME` shows which these are (\"No effect\"), and what to use instead "
     "where there is something. Of materials and patterns each parameter of a plug-in is told once, at the first "
     "node "
     "that sets it."},
    {"PARAM-CHOICE",
     "A parameter whose numbers or words stand for choices (a blend mode, a type of noise, a variable) has one that "
     "stands for none. The message says what is done and, as `kinora plugins NAME`, lists the choices."},
    {"PARAM-",
     "A parameter of a node, or what is connected to it, cannot be used as the scene says. The message says what was "
     "done "
     "instead; `kinora plugins NAME` shows types, ranges and what can be connected."},
    {"SHADER-DISPLACEMENT",
     "A Displace names a shader of the shading language that writes neither P nor N, so that it does nothing to the "
     "surface."},
};

}  // namespace

std::span<const Explanation> explanations() { return kExplanations; }

}  // namespace kinora::shade
