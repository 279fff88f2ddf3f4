// Push constants of the kernels that update the grids.
#ifndef RECORDS_UPDATE_PUSH_GLSL
#define RECORDS_UPDATE_PUSH_GLSL

// Push constants of the kernels that update the grids.
struct UpdatePush {
    uint first_cell;  // cell of the first workgroup
};

#endif
