// Casino-style die with rounded corners and scooped pips; opposite faces add up to seven.
// Millimetres.

side    = 16;
round_d = 24;       // ball that takes the corners off
pip_r   = 1.6;
pip_out = 0.6;      // centre of the scoop above the face
spread  = 4;        // from the middle of a face to its outer pips

// Where the pips of a face are, in units of `spread`.
function pips(n) = [
    if (n % 2 == 1) [0, 0],
    if (n >= 2) each [[-1, -1], [1, 1]],
    if (n >= 4) each [[-1, 1], [1, -1]],
    if (n == 6) each [[-1, 0], [1, 0]],
];

// Turns the top face to where face n goes.
turns = [[0, 0, 0], [90, 0, 0], [0, 90, 0], [0, -90, 0], [-90, 0, 0], [180, 0, 0]];

difference() {
    intersection() {
        cube(side, center = true);
        sphere(d = round_d);
    }
    for (n = [1 : 6]) rotate(turns[n - 1]) for (p = pips(n))
        translate([p[0] * spread, p[1] * spread, side / 2 + pip_out]) sphere(pip_r);
}
