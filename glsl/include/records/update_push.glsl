// Push constants of the kernels that update the grids.
#ifndef RECORDS_UPDATE_PUSH_GLSL
#define RECORDS_UPDATE_PUSH_GLSL

// Push constants of the kernels that update the grids.
struct UpdatePush {
    uint first_cell;  // cell of the first workgroup
    uint ends_step;   // 1: earlier targets count less, as at the end of a step; 0: their count stays, and only tables are computed
};

#endif
