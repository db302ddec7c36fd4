// The Stephenson six-bar of demos/stephenson.toml at drive angle 0. Lengths in mm.
//
// Physical curves are the links: "link", or "link.member" where the scene file or the results shall name the members. The
// ternary coupler ABP is a plate, drawn as a triangle of bars welded at its corners. Physical points are the joints:
// "joint A" is a pin through all links that have the end of a line there, "ground O" one in the ground too.

crank = 80; ab = 220; cb = 200; pr = 300; dr = 240;  // O, A, B, C make a crank-rocker
c_x = 250; d_x = 420; d_y = 40;                      // bearings in the ground, beside O = (0, 0)
p_along = 150; p_across = 120;                       // P, along AB and across it

// B, where the circles about A and C meet; then P on the coupler
b_x = crank + (ab^2 + (c_x - crank)^2 - cb^2) / (2 * (c_x - crank));
b_y = Sqrt(ab^2 - (b_x - crank)^2);
e_x = (b_x - crank) / ab; e_y = b_y / ab;
p_x = crank + p_along * e_x - p_across * e_y;
p_y = p_along * e_y + p_across * e_x;

// R, where the circles about P and D meet, on the left of the way from P to D
pd = Hypot(d_x - p_x, d_y - p_y);
f_x = (d_x - p_x) / pd; f_y = (d_y - p_y) / pd;
r_along = (pr^2 + pd^2 - dr^2) / (2 * pd);
r_across = Sqrt(pr^2 - r_along^2);

Point(1) = {0, 0, 0};
Point(2) = {crank, 0, 0};
Point(3) = {b_x, b_y, 0};
Point(4) = {c_x, 0, 0};
Point(5) = {p_x, p_y, 0};
Point(6) = {p_x + r_along * f_x - r_across * f_y, p_y + r_along * f_y + r_across * f_x, 0};
Point(7) = {d_x, d_y, 0};

Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {2, 5};
Line(4) = {3, 5};
Line(5) = {4, 3};
Line(6) = {5, 6};
Line(7) = {7, 6};
Transfinite Curve {1, 2, 3, 4, 5} = 3;
Transfinite Curve {6, 7} = 5;

Physical Point("ground O") = {1};
Physical Point("joint A") = {2};
Physical Point("joint B") = {3};
Physical Point("ground C") = {4};
Physical Point("joint P") = {5};
Physical Point("joint R") = {6};
Physical Point("ground D") = {7};
Physical Curve("crank") = {1};
Physical Curve("coupler.AB") = {2};
Physical Curve("coupler.AP") = {3};
Physical Curve("coupler.BP") = {4};
Physical Curve("rocker") = {5};
Physical Curve("bar") = {6};
Physical Curve("output") = {7};
