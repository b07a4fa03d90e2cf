#include "render/messages.h"

namespace kinora::render {

namespace {

constexpr Explanation kExplanations[] = {
    {"LIGHT-PORTAL",
     "A PxrPortalLight shows a dome through a rectangle: the PxrDomeLight whose lightColorMap is the portal's "
     "domeColorMap, else the first dome of the scene. Without either it is an even light of its own colour. What is "
     "said "
     "of the dome holds for its portals: its light filters multiply theirs, a mute dome's portals are mute, and what "
     "the dome's linking excludes they do not light. Dome and portal move and turn each by itself while the shutter "
     "is "
     "open, unless the file says portalToDome: then the dome stands to the portal as that says. A portalToDome that "
     "is "
     "no matrix leaves the dome standing as the portal does; domeTurns that are no quaternions leave it still."},
    {"PLUGIN-CREATE",
     "A plug-in was found but could not be set up; the message says why. What is used instead is what would be used "
     "if "
     "there were no such plug-in."},
    {"LIGHT-",
     "A light is set up in a way that gives no or other light than may be meant: a degenerate transform or size, a "
     "map "
     "that cannot be read, an angle outside its range. The message says what was done."},
    {"PROJECTION-",
     "A camera parameter cannot be used: a field of view outside 0 to 180 degrees, or a lens that cannot exist. The "
     "message says what is used instead."},
    {"RENDER-MEMORY", "There is not enough memory for the scene or the picture. Exit code 5."},
    {"RENDER-RESOLUTION",
     "Format, or --res, asks for a picture beyond what Kinora renders: 65,536 pixels on a side and 2^31 in all. Exit "
     "code 3."},
    {"RENDER-BLACK",
     "All of a finished picture's colour is 0. Either the camera sees no object (alpha is 0 everywhere; matte "
     "objects hold out and count "
     "for none), or no light reaches those that it sees. Messages before this one often say what was left out."},
    {"RENDER-SAMPLES",
     "The Hider's maxsamples is negative or more than 65,536. A negative one is ignored: PixelSamples, then 64, say "
     "how "
     "many samples a pixel has. Or its samplestride is not within 1 to 4,096: then every sample is taken."},
    {"RENDER-ADAPTIVE",
     "Adaptive sampling cannot be done as it is asked for. With a least number of samples (minsamples, --min-spp) "
     "above the most, every pixel takes the most. A part of a frame's samples (--samples) takes all of them in every "
     "pixel, for what earlier samples would have decided is not known to it: such parts merge to the picture without "
     "adaptive sampling, and so is a frame whose Hider takes one of several samples (samplestride). Parts by --crop "
     "decide as the whole frame does."},
    {"RENDER-NOISE",
     "--error asks for a picture whose relative error (root mean square over the pixels, as two halves of the "
     "samples "
     "differ) is at most so much, and the samples that --max-spp allows did not suffice. The picture is complete "
     "otherwise."},
    {"RENDER-CHECKPOINT",
     "A checkpoint (--checkpoint, Option \"checkpoint\") could not be written, or the scene says no time for them "
     "that "
     "can be read. The render goes on; if it is stopped, --recover finds the last checkpoint that was written."},
    {"RENDER-CHECKPOINT-COMMAND",
     "Option \"checkpoint\" \"string command\" names a program to run after each checkpoint. Scenes run programs "
     "with "
     "--allow-exec alone; a program that ends with another code than 0 is told, and the render goes on."},
    {"RENDER-RECOVER",
     "--recover found a checkpoint that this frame cannot go on from: of another scene, another seed or frame, other "
     "settings of adaptive sampling or more samples than are asked for, or a file that is broken. The message says "
     "which. The frame is rendered from its first sample, and its own checkpoints take the place of that file."},
    {"RENDER-RECOVERED",
     "--recover found a checkpoint of this frame. Its samples are not taken again, and the picture has the bits of a "
     "render that was never stopped."},
    {"RENDER-CROP",
     "CropWindow, or --crop, rounded to pixels as RIB says, is empty: a pixel belongs to the window that holds its "
     "top "
     "left corner, and narrow windows may lie between two of them. Nothing is rendered; the exit code is 3, or 2 "
     "where "
     "the command line named the window."},
    {"RENDER-PROCEDURAL-BOUND",
     "A procedural holds things outside of the bound that its request says. It is read when a ray first meets the "
     "bound: "
     "rays that pass the bound and would meet what lies outside find it only once other rays have had it read, so "
     "that "
     "parts of the picture may lack it. The message says by which factor the bound must be larger. "
     "--read-procedurals "
     "reads all of them first."},
    {"RENDER-PROCEDURAL-BUDGET",
     "Archives and programs that are read when rays meet them are dropped and read again where they do not fit in "
     "their "
     "budget together (--geometry-cache, Option \"limits\" \"int geocachememory\" in KiB, or a half of "
     "--memory-limit). "
     "Paths are followed in groups, of which a small one has 16. Some of these meet more at the same time than the "
     "budget holds, so that it is passed for their sake. The picture is the same. Integrators that keep records of "
     "light paths (PxrVCM, PxrUnified with traceLightPaths) hold all that was read, and say so where it is more."},
    {"RENDER-PROCEDURAL-CHANGED",
     "An archive, or what a program prints, is not what it was when it was first read for this frame: it had been "
     "dropped "
     "to keep a budget of memory, and was read again. What it gives now is used from there on. Samples that were "
     "taken "
     "before saw what it gave before, and parts of the frame do not merge with others. Each file is named once."},
    {"RENDER-FLAT",
     "An object, or one placing of it, has a transformation that leaves it no volume to speak of, or makes it so "
     "small or "
     "puts it so far away that no ray can be brought into its space. It is left out there. What only passes such a "
     "moment "
     "while it moves, as something that turns inside out, is drawn: rays keep a millionth of the shutter's time "
     "away."},
    {"RENDER-FRAME-ASPECT",
     "--res asks for a picture of another shape than the scene's FrameAspectRatio. As with Format, the picture is "
     "the "
     "largest part of what is asked for that has the scene's shape: nothing is squeezed, and what is seen stays the "
     "same."},
    {"RENDER-SHUTTER",
     "The numbers of the shutter's opening shape (shutterOpenTime, shutterCloseTime and shutteropening of a Camera, "
     "or "
     "shutteropening of the Hider) do not lie in 0 to 1, are in the wrong order or too few. The shutter opens and "
     "closes "
     "at once."},
    {"RENDER-SOLID",
     "A solid (SolidBegin ... SolidEnd) cannot be resolved as said. Each primitive solid has to be closed: lines "
     "through it "
     "that leave it less often than they enter tell of a hole, as of a Cylinder without its Disks, and a Disk or "
     "curves "
     "alone enclose nothing. Then, and when a difference has nothing to take away from or a solid has more than 8192 "
     "parts or "
     "one that is scaled or placed beyond a billion, "
     "all surfaces of that solid are drawn as they are. Operands without any surface are left out."},
    {"RENDER-TRACE-SET",
     "A subset of objects for rays (trace:reflectsubset, shadowsubset, transmitsubset and their exclude forms) names "
     "a "
     "group that no object is a member of (grouping:membership), or there are more different subsets than rays can "
     "tell "
     "apart (26; one for shadows counts twice). Names without members select nothing; subsets beyond the limit are "
     "ignored."},
    {"RENDER-CAMERA",
     "The camera's transform cannot be inverted or holds NaN: the identity stands in for it. Or its screen window, "
     "near "
     "clipping plane or lens is beyond 1e15, where no ray can begin: the usual one, none, and a pinhole stand in."},
    {"RENDER-NO-CAMERA",
     "The scene has no Projection and no Camera. What RIB says then is an orthographic view along z from the "
     "origin."},
    {"RENDER-NO-LIGHTS",
     "No light of the scene is rendered: there is none, or none that is known. Glowing surfaces still light the "
     "rest; "
     "where nothing glows and no Integrator is named, PxrDefault lights every surface from the eye."},
    {"RENDER-CLASSIC-LIGHT",
     "LightSource and AreaLightSource name light shaders of the time before RIS. The message names the light that "
     "stands in. ambientlight, distantlight, pointlight and spotlight, and shaders with one of these words in their "
     "names, follow the RenderMan Interface Specification; intensity is what a white surface that faces the light "
     "shows (of point and spot at distance 1 in the world). Ambient light casts no shadows and makes no highlights. "
     "Other shaders are known by words in their names (area, env, uber ...), else by the parameters that they are "
     "given: coneangle makes a spot, to a distant light, from a point, lighttype or cuton the controls of Barzel's "
     "model (BarzelLightFilter). Shadow maps are not read: shadows are traced. The shape of an unknown "
     "AreaLightSource emits, all of it together as much as a point light of its intensity; one with a falloff of its "
     "own is not seen itself. An AreaLightSource of the first RIS years (PxrStdAreaLight and its kin) becomes the "
     "modern light of its shape, which takes the place of its geometry; radiance follows intensity and exposure as "
     "they stand."},
    {"CLASSIC-LIGHT-OUT",
     "A LightSource is left out, because nothing is known of it (neither its name nor its parameters say what it "
     "does), or because it stands for light that paths find by themselves: caustics of photon maps, light bounced "
     "between surfaces. Where no other light is left, the scene has a headlight. Ambient light in an object "
     "(ObjectBegin) is left out as well: it has no place, and is said once, in the world. Other lights there shine "
     "from each place of the object, on everything."},
    {"CLASSIC-SURFACE",
     "A Surface names a shader of the RenderMan Shading Language, which Kinora does not run, and it is none of the "
     "standard ones (constant, matte, metal, shinymetal, plastic, paintedplastic, defaultsurface, null; glass). One "
     "of these stands in: by a word in the shader's name (metal, plastic, glass, constant ...), else matte, or "
     "plastic "
     "where Ks or specularcolor is given. Color and Opacity, and of its parameters those that many shaders share, "
     "count as they would there: Ka (at most 1), Kd, Ks, Kr, roughness, specularcolor, a colour by a usual name "
     "(basecolor, "
     "surfacecolor ...), a texture (texturename, mapname ...). "
     "Opacity that differs between channels counts as its mean. Atmosphere fog and depthcue fade these surfaces "
     "by the length of the ray that meets them; not glass, not objects with a Bxdf, not what stands behind all "
     "objects."},
    {"LIGHT-OFF",
     "A LightSource lights what is said after it in its own attribute block, as the RenderMan Interface has it: at "
     "AttributeEnd the list of lights before comes back. This one meets no object. Illuminate HANDLE 1 behind the "
     "block "
     "switches it on for all that follows; a Light of RIS needs none of this."},
    {"DISPLACEMENT-BOUND",
     "A displacement moves points farther than Attribute \"displacementbound\" \"float sphere\" says, measured in "
     "the "
     "coordinatesystem that it names (the object's own, if none). Kinora draws all that moves and needs no bound; "
     "renderers that trust it cut holes there. The message says which bound holds the surface. Without a bound "
     "nothing "
     "is checked. Surfaces that are diced where rays ask are looked for within the bound: their points move no "
     "farther, or twice as far at edges and corners, where surfaces that meet at an angle are moved as one."},
    {"DISPLACEMENT-COARSE",
     "A displaced surface asks for more micropolygons than are made of one: it is far larger than what is seen of "
     "it, "
     "or \"dice\" \"float micropolygonlength\" is very small. Its micropolygons are longer than asked for, by what "
     "the "
     "message says, and relief smaller than they are is lost. A surface that is diced where rays ask and has no "
     "displacementbound is diced all over once: 200 million triangles at most. What lies far outside a view without "
     "perspective is "
     "cut "
     "less the farther it is, and far from the eye in others, so that size alone is no reason."},
    {"DISPLACEMENT-LEVELS",
     "A displaced surface asks to be diced where rays ask (Attribute \"dice\" \"int levels\" [1]), and the faces "
     "that it "
     "is made of are hardly larger than micropolygons: nothing coarser could be made of them. It is diced at once, "
     "as "
     "without the attribute."},
    {"GEOMETRY-CACHE-SMALL",
     "The geometry cache (--geometry-cache, Option \"limits\" \"int geocachememory\" in KiB) is smaller than one "
     "patch "
     "of a surface that is diced where rays ask. The picture is the same, but each patch is diced again whenever "
     "another "
     "one was in between."},
    {"DISPLACEMENT-KIND",
     "Curves and points have a displacement. Only surfaces are displaced: polygons, subdivision meshes, patches, "
     "NURBS, "
     "quadrics and blobbies."},
    {"DISPLACEMENT-SCALE",
     "A displacement is measured in lengths of the world or of a space of the scene (PxrDispTransform "
     "dispScaleSpace, or "
     "a shader that moves P), and instances of the object that it moves have different scales. The surface is made "
     "once "
     "for all of them, with the scale of the first: on those that are larger it goes farther, on smaller ones less "
     "far."},
    {"DISPLACEMENT-NOT-FINITE",
     "A displacement gives some points an offset that is not a number, infinite or beyond 1e15 units: a division by "
     "0 "
     "in its patterns, or a texture that holds such values. These points stay where they are without it. "
     "The message says on which face the first one is."},
    {"LIGHT-SHADOW",
     "What a light says of its shadows has no meaning: a shadowColor beyond 0 to 1, a shadowFalloffGamma that is not "
     "above "
     "0, a shadowFalloff without the shadowDistance that it ends at, or a number that is not finite. The message "
     "says "
     "what stands in."},
    {"LIGHT-CONNECTION",
     "A parameter of a light is given as a reference to a pattern. Lights are the same from wherever they are asked "
     "and run no patterns: the parameter has its default. Give its value, a picture (lightColorMap), or make the "
     "surface glow by its material, where patterns run."},
    {"LIGHT-MOTION",
     "A light's transform changes the light's size or shape while the shutter is open, or mirrors it. Lights move "
     "and "
     "turn within a frame, and their filters with them, but keep the size and shape that they have at the middle of "
     "the shutter; so do domes that are seen through portals. One that mirrors stands where it is at that time. "
     "Surfaces that glow change those too."},
    {"LIGHT-GEOMETRY",
     "A light has geometry (PxrMeshLight, AreaLightSource) of a kind, or in a state, that lights do not follow: "
     "curves and points have no surface that light could leave, a displacement of which nothing could be made leaves "
     "it where it was before, and the cuts of solids are those of surfaces alone. The message says which it is and "
     "what stands in. An object that glows by its material has all of these."},
    {"LIGHT-INDIRECT",
     "A light has Attribute \"visibility\" \"int indirect\" [0] and says its transmission too. RenderMan's exporters "
     "write both for every light, whatever its maker wants, and mirrors show these lights there; so they do here. To "
     "hide a light from mirrors and clear glass say indirect without transmission."},
    {"LIGHT-NEAR",
     "The intensityNearDist of a light is negative or no finite number. It is the distance in world units below "
     "which "
     "the light's brightness rises no more; 0 is none."},
    {"LIGHT-LINK",
     "Attribute \"lighting\" \"string subset\" or \"excludesubset\" of an object, or Illuminate, names a light, or a "
     "group of lights, that the scene has not; or \"lightfilter\" \"string subset\" a group that is none of the "
     "linkingGroups of its light filters. An object whose subset names no light at all is lit by none, only by "
     "what other "
     "objects "
     "send it. The message stands once for each name."},
    {"LIGHT-FILTER-SPACE",
     "The coordsys of a light filter names no coordinate system of the scene. CoordinateSystem or "
     "ScopedCoordinateSystem makes one; the light's own space stands in."},
    {"ASSET-IES-MISSING",
     "The file that a light's iesProfile names is nowhere along the search path of textures. The light shines as if "
     "it "
     "named none."},
    {"ASSET-IES-READ",
     "The file that a light's iesProfile names is no IES LM-63 file that can be read: the message says where and "
     "why. "
     "Text up to a line TILT=NONE is free; numbers follow: counts, sizes, angles that ascend, a candela value for "
     "each "
     "pair of angles. Horizontal angles go from 0 to 0, 90, 180 or 360 (or from 90 to 270), vertical ones lie within "
     "0 and 180, for types A and B within -90 and 90. The light shines as if it named no profile."},
    {"LIGHT-FILTER-RAMP",
     "The knots of a light filter's ramp are missing, more than 64, not ascending, or not numbers, or its values are "
     "fewer than its knots. The ramp counts as 1 everywhere; the filter's other settings hold."},
    {"LIGHT-FILTER-MAP",
     "The image of a cookie or gobo filter is not named, holds no texels, or is too large (2^31 numbers). The filter "
     "leaves its light as it is."},
    {"FILTER-REFERENCE",
     "A filter combiner names a filter by a handle that no SampleFilter, DisplayFilter or LightFilter of its kind "
     "(for "
     "lights: in force where the Light stands) has, or the handle "
     "of a combiner that names it in turn. It is left out; the "
     "others run in the order in which the combiner names them."},
    {"FILTER-FILM",
     "filmMinX, filmMinY, filmMaxX and filmMaxY of a filter that lays a picture behind or over the frame leave no "
     "window: a minimum is not below its maximum. The message says what is done instead."},
    {"FILTER-PICTURE",
     "A filter that lays a picture behind or over the frame has none: 'filename' is empty, or the picture has no "
     "pixels "
     "or more than 131,072 on a side. The filter does nothing."},
    {"LIGHT-CHANNEL",
     "A light that marks what it is linked to (PxrAovLight) names a channel that no Display holds. It marks nothing. "
     "Add "
     "DisplayChannel \"float mask\" and a Display of \"mask\", with the light's aovName as the channel's name or "
     "source."},
    {"FILTER-SPLATS",
     "Sample filters change what the camera's paths bring, sample by sample. Paths from the lights (PxrVCM, "
     "PxrUnified "
     "with light paths) bring light to pixels of the finished picture, which no sample filter sees."},
    {"FILTER-CHANNEL",
     "A sample or display filter works on a channel (its parameter aov, for instance) that no Display of the frame "
     "holds. The filter runs without it."},
    {"RENDER-INSTANCE-GONE",
     "An instance is of an object that the scene does not have, as after an edit that removed the object alone. The "
     "instance is left out."},
    {"RENDER-EMPTY",
     "A frame was read whose world has no object and no light: nothing stands between WorldBegin and WorldEnd, or "
     "all of "
     "it was refused. Its picture is written, empty, and the program ends with code 3, as for a file without a "
     "scene; "
     "further frames are rendered."},
    {"RENDER-NO-WORLD",
     "A picture was asked for after a load or an update that gave nothing to render. The messages before say why."},
    {"EDIT-EMPTY",
     "An edit left an empty place in a list of the scene. It is taken out, as if the thing had been erased."},
    {"EDIT-TRANSFORM",
     "An edit left a transform with another number of times than matrices, or with times that do not rise. Its first "
     "matrix is used, or the identity where it has none."},
    {"RENDER-INSTANCES", "Instances inside instances multiply; beyond a bound the rest is left out."},
    {"RENDER-LEARNING",
     "An integrator of a plug-in declares that it learns (IntegratorTraits::learning), but has several stages of "
     "camera "
     "paths, or another stage behind them, or lacks IntegratorFunctions::learn. The frame is rendered with nothing "
     "learned; its bits do not depend on parts or crops either way."},
    {"RENDER-RECORDS",
     "An integrator keeps records from one stage of a pass for the next, in lists that it declares. It appended to a "
     "list that does not exist or that another stage writes; those records were dropped. A fault of the plug-in."},
    {"MEDIUM-AGGREGATE",
     "An integrator (volumeAggregate, volumeAggregateCamera, volumeAggregateIndirect, volumeAggregateTransmission) "
     "or a "
     "surface (volumeAggregateName) asks for volumes by the name of an aggregate that no volume is in. Volumes are "
     "put "
     "into aggregates by Attribute \"volume\" \"string[] aggregate\"; those that say nothing are in "
     "\"globalVolumeAggregate\", which integrators ask for by default."},
    {"MEDIUM-BOUND",
     "Distances in a medium are drawn by bounds of its extinction, found by looking at its patterns on a lattice of "
     "points, or by maxDensity of its material. Somewhere the extinction is larger than the bound. The picture is "
     "still "
     "right in the mean, and noisier there: state the true maximum, or make the pattern smoother."},
    {"MEDIUM-ENDLESS",
     "A ray met a medium more than 65,536 times before it came through or was scattered: its density is enormous, or "
     "far "
     "below the bound that was given for it. Such rays count as absorbed."},
    {"MEDIUM-FIELD",
     "A Volume request brings numbers for its voxels, and their count is neither that of its points nor three times "
     "that: the field is left out. Or the fourth string of \"blobbydso:stringargs\" is no dictionary (JSON), or its "
     "\"filterWidth\" no number from 0 to 1000: grids are looked up as without it; other words of it are not known."},
    {"MEDIUM-INTEGRATOR",
     "The scene has fog, smoke or another medium, and its integrator cannot follow light that is scattered there. "
     "Media "
     "absorb what they would scatter, and what they emit is missing. PxrPathTracer, PxrDirectLighting, PxrVCM and "
     "PxrUnified can."},
    {"MEDIUM-LEFT-OUT",
     "Volumes are in aggregates (Attribute \"volume\" \"string[] aggregate\") that the integrator asks for in none "
     "of its "
     "rays, and no surface that encloses something (volumeAggregateName) for its inside: they are left out. Its "
     "volumeAggregate names aggregates, several with blanks between them; "
     "\"globalVolumeAggregate\" is that of volumes that say nothing."},
    {"MEDIUM-NONE",
     "A Volume request has the material of a surface, or none: nothing would fill it. It is left out."},
    {"MEDIUM-OPEN",
     "What has the material of a medium, or has volumes inside (volumeAggregateName), encloses no space. Curves and "
     "points are left out, and have none. A surface with holes, or "
     "one "
     "side of a box as a primitive of its own, bounds its medium as far as it goes: rays that meet it once are "
     "inside "
     "from there on, or were until then."},
    {"MEDIUM-OVERLAP",
     "At one point more than eight media overlap. Those that the ray entered last are left out there."},
    {"MEDIUM-SOLID",
     "A part of a solid (SolidBegin) has the material of a medium, or has volumes inside (volumeAggregateName). What "
     "a "
     "solid leaves of its parts is known for surfaces alone: the medium is left out, the volumes are not inside."},
    {"MEDIUM-VELOCITY",
     "velocityPrimVar of a PxrVolume names no grid or voxels of three components in its Volume request (nor three of "
     "one, \"NAME.x\" and so on): the medium stands still. Or its velocity carries it farther while the shutter is "
     "open "
     "than the medium is large: it is carried by its own size at most. Velocities are in object space, by unit of "
     "the "
     "shutter's time."},
    {"RENDER-PASSES",
     "A ray may pass 256 surfaces that are partly absent (presence), clear to shadows, or inside a medium of higher "
     "priority. Rays that would pass more were given up: camera and indirect rays saw nothing beyond, shadow rays "
     "were "
     "blocked. The message counts them."},
    {"SUBSURFACE-OPEN",
     "Paths that went below a surface with subsurface scattering met nothing of the object there: its mesh is a "
     "sheet, "
     "has a hole or is inside out, or the object is made of curves or points, which have no inside. Their light "
     "comes "
     "out where it went in, as from a diffuse surface of the same colour. The message names the first such object."},
    {"SUBSURFACE-LONG",
     "Paths below a surface made 8,192 free flights, or came far outside of everything through a crack in the mesh. "
     "Their light comes out where it went in. A few of them are harmless; many say that the mean free path is tiny "
     "beside the object while nothing is absorbed, or that the mesh is not closed."},
    {"RENDER-NONFINITE",
     "Some samples gave infinity or not-a-number. They were left out together with their weight, so the pixel is the "
     "mean "
     "of the others. The message names the first; --only-sample X,Y,S prints what its path met."},
    {"RENDER-NO-SAMPLES",
     "A part of a frame (`kinora render --samples`) was interrupted before every pixel had its first sample. There "
     "is "
     "nothing that could be merged, so no file is written."},
};

}  // namespace

std::span<const Explanation> explanations() { return kExplanations; }

}  // namespace kinora::render
