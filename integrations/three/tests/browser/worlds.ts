// Worlds to bake.

/** As OBJ: a ground of 40 × 40, and on it a wall of 2 × 4 × 6 around `x = 0`, `z = -5`. */
export const WALL_AND_GROUND = `v -20 0 -20\nv -20 0 20\nv 20 0 20\nv 20 0 -20
v -1 0 -8\nv 1 0 -8\nv 1 0 -2\nv -1 0 -2\nv -1 4 -8\nv 1 4 -8\nv 1 4 -2\nv -1 4 -2
f 1 2 3 4\nf 5 6 7 8\nf 12 11 10 9\nf 5 9 10 6\nf 6 10 11 7\nf 7 11 12 8\nf 8 12 9 5\n`;
