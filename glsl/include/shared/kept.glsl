// Marks of a struct's members that a wave keeps between kernels. build/glsl/wave.rs gives each part of a struct a place in a path's slot,
// and writes the functions that store and load it (generated/wave.glsl). The marks mean nothing to the compiler.
#ifndef KEPT_GLSL
#define KEPT_GLSL

// A member that is kept, in the named part. Parts are stored and loaded one by one. KEPT(never) within a kept struct is not kept.
#define KEPT(part)

#endif
