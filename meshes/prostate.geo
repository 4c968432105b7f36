// A prostate in its surroundings, about 1250 triangles. Metres; the needle enters at the right side.
// Make the mesh with:  gmsh -2 -format msh41 prostate.geo -o prostate.msh

width = 0.08;
height = 0.06;
centre_x = 0.035;
centre_y = 0.030;
half_width = 0.0175;   // prostate of 3.5 x 2.6 cm
half_height = 0.013;
size = 0.00326;

Point(1) = {0, 0, 0, size};
Point(2) = {width, 0, 0, size};
Point(3) = {width, height, 0, size};
Point(4) = {0, height, 0, size};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};

Point(5) = {centre_x, centre_y, 0, size};
Point(6) = {centre_x + half_width, centre_y, 0, size};
Point(7) = {centre_x, centre_y + half_height, 0, size};
Point(8) = {centre_x - half_width, centre_y, 0, size};
Point(9) = {centre_x, centre_y - half_height, 0, size};
Ellipse(5) = {6, 5, 6, 7};
Ellipse(6) = {7, 5, 6, 8};
Ellipse(7) = {8, 5, 6, 9};
Ellipse(8) = {9, 5, 6, 6};

Curve Loop(1) = {1, 2, 3, 4};
Curve Loop(2) = {5, 6, 7, 8};
Plane Surface(1) = {2};
Plane Surface(2) = {1, 2};

Physical Surface("prostate") = {1};
Physical Surface("surrounding") = {2};
Physical Curve("bottom") = {1};
Physical Curve("right") = {2};
Physical Curve("top") = {3};
Physical Curve("left") = {4};
Physical Curve("prostate_outline") = {5, 6, 7, 8};
