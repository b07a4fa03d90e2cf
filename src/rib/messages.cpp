#include "rib/reader.h"

namespace kinora::rib {

namespace {

constexpr Explanation kExplanations[] = {
    {"RIB-OPEN",
     "A RIB file named on the command line cannot be opened. The message gives the system's reason. Check the "
     "spelling and the "
     "permissions; '-' reads standard input."},
    {"RIB-ZIP",
     "A zip archive was named as a scene, and it is damaged, of a form that is not understood, holds no RIB file, or "
     "several of which none is the scene: the one named like the archive, else the one with a WorldBegin, else the "
     "one that stands above all others. Name the member: scene.zip!folder/file.rib."},
    {"RIB-DIRMAP",
     "Option \"searchpath\" \"string dirmap\" says which folders of other machines stand where on this one: "
     "[\"ZONE\" \"FROM\" \"TO\"], any number of times in one string. Entries of the zone NFS count, those of other "
     "zones (UNC) where TO is a folder of this machine. --dirmap FROM=TO of the command line comes first."},
    {"RIB-DIRECTORY", "A directory was named where a RIB file was expected. Name the file inside it."},
    {"RIB-PROCEDURAL-LIGHT",
     "What a program prints (Procedural \"RunProgram\") is known when a ray first reaches its bound. Which lights "
     "there are has to be known before the first ray, so lights in it are left out, and those of objects that it "
     "places. Attribute \"procedural\" \"int "
     "immediatesubdivide\" [1] before it, or a bound without end, has it run with the scene. Archives are searched "
     "for lights while the scene is read, and those that hold some are read with it; one that changes between the "
     "two "
     "is treated as a program."},
    {"RIB-EMPTY",
     "A file was opened and holds no request at all: it is empty, holds only comments, or is not RIB. Often an "
     "exporter failed and "
     "left an empty file behind."},
    {"RIB-NO-WORLD",
     "The files were read to their end and no WorldBegin ... WorldEnd was among them, so there is no frame to "
     "render. A file that "
     "holds only geometry is an archive: read it with ReadArchive from a scene that has a camera and a world."},
    {"RIB-OUTSIDE-WORLD",
     "Geometry and lights count only between WorldBegin and WorldEnd or inside ObjectBegin ... ObjectEnd. What stood "
     "elsewhere was "
     "counted and ignored."},
    {"RIB-TRUNCATED",
     "The stream ended inside a binary token or inside compressed data. What came before is used; the token that was "
     "cut is not. "
     "Write or copy the file again."},
    {"RIB-SYNTAX",
     "Characters were met that are no part of RIB: stray punctuation, a number with letters behind it, values before "
     "the first "
     "request. They are skipped up to the next blank. Only the first of a file is shown. Often a '#' before a "
     "comment or a quote is "
     "missing."},
    {"RIB-BINARY",
     "A byte with its top bit set has no meaning in RIB's binary encoding, or refers to a request or string token "
     "that was never "
     "defined. Text saved in an encoding with accented letters outside of strings gives the same message."},
    {"RIB-QUOTES",
     "A string stood in single quotes, or a word had no quotes and was on the line of its request. It is read as a "
     "string. A word at "
     "the start of a line is taken for a request instead."},
    {"RIB-STRING",
     "A string has no closing quote. When the next line begins with the name of a request, or the file ends, the "
     "string is taken to "
     "end with its line."},
    {"RIB-BRACKET",
     "A '[' was never closed, or a ']' closes nothing. An array left open ends where a request name begins a line."},
    {"RIB-ARRAY",
     "An array holds brackets inside brackets, or numbers and strings together. Inner brackets are ignored; the kind "
     "of the first "
     "value decides which values stay."},
    {"RIB-UNKNOWN-REQUEST",
     "A word stands where a request was expected and no request has this name. It is skipped together with its "
     "arguments, up to the "
     "next known request. Request names are case-sensitive."},
    {"RIB-ARGUMENTS",
     "A request lacks arguments or has them of the wrong kind or outside of what they may be. The request is ignored "
     "and the state "
     "stays as it was."},
    {"RIB-PARAMETER",
     "A parameter list is pairs of a name and a value. A name without a value, or a value without a name, is "
     "ignored."},
    {"RIB-DECLARATION",
     "A declaration must read \"[class] type[n] name\": class is constant, uniform, varying, vertex, facevarying or "
     "facevertex; type "
     "is float, int, string, color, point, vector, normal, hpoint, matrix, mpoint, or a node type; [n] is optional. "
     "Where n is left out, type[], or is 0, an array is as long as its value, and one without values counts as not "
     "given; primitive variables that are not constant need n, since it tells where an element ends."},
    {"RIB-UNDECLARED",
     "A parameter's name was neither declared inline nor by Declare nor is it predeclared. On plug-ins its type is "
     "taken from its "
     "value; on geometry it is ignored, because nothing says how its values spread over the surface."},
    {"RIB-TYPE",
     "A parameter was given values of another kind than its declaration says: strings for numbers, numbers for "
     "strings, or fractions "
     "for an integer. Fractions are cut off; otherwise the parameter is ignored and its default holds. Integers "
     "beyond "
     "2147483647 (hashes, say) become the nearest one."},
    {"RIB-ARRAY-LENGTH",
     "The number of values of a parameter does not fit its type: a color takes 3, a float[2] takes 2, a matrix 16. "
     "Values that are no "
     "whole number of elements make the parameter ignored; several whole elements are kept as an array."},
    {"RIB-NUMBER",
     "A number is nan, infinite, or larger than the largest float (3.4e38). In most places 0 or 3.4e38 is used; a "
     "primitive whose "
     "points hold such a number is left out."},
    {"RIB-PRIMVAR-COUNT",
     "A primitive variable has another number of values than its class takes on this primitive: constant 1; uniform "
     "one per face or "
     "curve; varying and vertex one per corner, point or control point; facevarying one per corner of each face. The "
     "variable is left "
     "out, the primitive stays."},
    {"RIB-PRIMVAR-ONE",
     "A primitive variable has one value where its class takes several. The value is used for the whole primitive; "
     "declare the "
     "variable constant to say so."},
    {"RIB-MISSING-P",
     "A primitive has no \"P\" (or \"Pw\") that could be used, so there is nothing to draw. It is left out."},
    {"RIB-INDEX",
     "A mesh refers to a point that it does not have, or to a negative one. The primitive is left out; a mesh with a "
     "wrong index is "
     "mostly a mesh whose points were cut short."},
    {"RIB-SHAPE",
     "The counts of a primitive do not fit together: corners and indices, loops and faces, points and sizes, knots "
     "and orders, or a "
     "face of fewer than three vertices. The primitive is left out."},
    {"RIB-TAGS",
     "The tags of a subdivision mesh claim more arguments than were given. The tags before the wrong one are used."},
    {"RIB-SCHEME", "A subdivision mesh names a scheme that does not exist. catmull-clark is used."},
    {"RIB-TRANSFORM",
     "A transform cannot be inverted (a scale of 0), or holds nan or infinity, or all transforms together grow "
     "beyond all numbers. The "
     "identity is used in its place, or the transform is ignored."},
    {"RIB-COORDSYS",
     "CoordSysTransform names a coordinate system that was not marked by CoordinateSystem before, or one that "
     "ScopedCoordinateSystem marked in a scope that has ended. Or two scopes gave theirs one name: patterns "
     "know the first."},
    {"RIB-NESTING",
     "Blocks are not balanced: an end without its begin is ignored; a block left open inside another is closed where "
     "the outer one "
     "ends; what is open at the end of the file is closed there, and motion blocks, inline archives, edits and "
     "conditions at the end of the archive that began them. Frames and worlds in an archive that is read inside "
     "a world are attribute blocks of that world."},
    {"RIB-SOLID",
     "SolidBegin names an operation that does not exist: what stands in the block is drawn as it is. Or solids stand "
     "in a primitive solid, which holds surfaces alone: they are united."},
    {"RIB-DEPTH",
     "Blocks or archives are nested deeper, or archives are read more often, than a scene sensibly does. What is "
     "beyond the limit is "
     "not opened. The limits keep a broken or hostile file from using all memory."},
    {"RIB-RECURSION",
     "An archive reads itself, or an object holds an instance of itself, directly or through others. The inner use "
     "is ignored."},
    {"RIB-MISSPELT",
     "An Attribute, an Option or a parameter of the Hider has a name that differs by a letter from one that is "
     "known, "
     "or a string where that takes a number (or the other way round), or Hider \"raytrace\" has a parameter that "
     "nobody "
     "knows, or an order of buckets does not exist. It is kept in the scene description, where "
     "nothing asks for it, and what it was to change stays as it is. Names of other groups and further words of "
     "one's "
     "own are no mistake; put them into the group \"user\"."},
    {"RIB-NO-EFFECT-",
     "An option, an attribute, a hider, or a parameter of the Hider or of a Display is known by name and asks for "
     "something that is not done here; the message says what is done instead, or what asks for it. Values that ask "
     "for what is done anyway are not told. Each name is reported once, where it is first met."},
    {"RIB-INSTANCE-VALUES",
     "ObjectInstance was given primitive variables. An instance has the attributes that stand before it and the "
     "geometry of its object, no values of its own: what differs from instance to instance is an Attribute \"user\", "
     "read by the pattern PxrAttribute or by getattribute() of a shader, or a Color."},
    {"RIB-HANDLE", "A handle is used that no request above has defined. The request that uses it is ignored."},
    {"RIB-RESOURCE",
     "Resource \"attributes\" names a subset that is not known; all attributes but the transform are restored."},
    {"RIB-REFERENCE",
     "A \"reference\" parameter names a node that was not declared above it in the same or an outer attribute block. "
     "The parameter's "
     "default is used. Patterns must stand before what reads them."},
    {"RIB-CYCLE",
     "Nodes of a shading network read each other in a circle. The reference that closes the circle is dropped."},
    {"RIB-MOTION",
     "A motion block is not sound: times that do not increase, another number of requests than times, different "
     "requests, geometry "
     "that does not match from time to time, a block inside a block, or transforms in one another that have more "
     "keys "
     "than are kept. The times that fit are used."},
    {"RIB-MOTION-CLOSE",
     "Motion is kept at even times over the shutter, 65 at most. Times of a motion block that are closer than 1/64 "
     "of "
     "the shutter fall between them: a jump takes that long, and what lasts no longer may be missed. Open the "
     "shutter "
     "for a shorter time, or put such times farther apart."},
    {"RIB-MOTION-STATIC",
     "A request stands in a motion block that cannot move; its first value is used for the whole time. Blobbies, "
     "volumes "
     "and shapes by name move by their transforms alone."},
    {"RIB-CONDITION",
     "The expression of IfBegin or ElseIf cannot be evaluated: it is not well formed, or a name in it is not "
     "defined (attributes and options have the values that hold where nobody says them). It counts as "
     "false. defined(name) asks whether a name is defined."},
    {"RIB-OPTION-IN-WORLD",
     "Options (format, displays, integrator, hider, cameras ...) are frozen at WorldBegin. One that stands inside "
     "the world is ignored."},
    {"RIB-KEPT-",
     "A request is understood but nothing renders it yet. It is kept in the scene description, so that nothing is "
     "lost when the scene "
     "is written again, and has no effect on the picture. Each such request is reported once, where it is first "
     "met."},
    {"ASSET-PROGRAM",
     "Procedural or Procedural2 \"RunProgram\" or \"DynamicLoad\" names a program, or a shared object, whose output "
     "would be part "
     "of "
     "the scene. It is run, since --allow-exec was given, but is not found, cannot be started, crashes, fails "
     "without "
     "an answer, takes more than 60 seconds or prints more than a gigabyte. It is ended and left out. Shared objects "
     "are run by kinora-procedural, which stands beside kinora; what it prints to standard error says more, and "
     "kinora-procedural OBJECT DATA runs it by hand. With --strict the exit code is 4."},
    {"ASSET-PROGRAM-REFUSED",
     "Procedural or Procedural2 \"RunProgram\" or \"DynamicLoad\" names a program, or a shared object, whose output "
     "would be part of the scene. They are run with --allow-exec alone: a scene from elsewhere could do anything "
     "with "
     "the rights of who renders it. What it would draw is left out; with --strict the exit code is 4."},
    {"PLUGIN-PROCEDURAL",
     "Procedural or Procedural2 names a kind that is none of DelayedReadArchive, RunProgram and DynamicLoad (of "
     "Procedural2 with a 2 at the end, which may be left out). What it would draw is left out; with --strict the "
     "exit "
     "code is 4. An archive of what it draws can stand in its place."},
    {"ASSET-MISSING-ARCHIVE",
     "An archive named by ReadArchive or a delayed procedural is not found: not as named, not beside the file that "
     "names it, not along "
     "the search path, and not by its base name there. It is left out. --strict makes this an error; --dirmap "
     "FROM=TO and "
     "--search-path archive=DIR help with scenes from another machine."},
};

}  // namespace

std::span<const Explanation> explanations() { return kExplanations; }

}  // namespace kinora::rib
