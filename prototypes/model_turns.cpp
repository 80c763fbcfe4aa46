#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <filesystem>
#include <algorithm>
#include "libshape/edge_space/patch_turns.h"
#include "libshape/model/shape_model.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/embedding/report.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/base/threads.h"
using namespace shape; using namespace shape::internal; using Eigen::VectorXd;
struct M{Points p;Faces f;};
M read(const std::string&path){std::ifstream s(path,std::ios::binary);std::stringstream b;b<<s.rdbuf();std::string d=b.str();auto h=d.find("end_header\n")+11;std::string t=d.substr(0,h);int nv=std::stoi(t.substr(t.find("element vertex ")+15)),nf=std::stoi(t.substr(t.find("element face ")+13));M m;m.p.resize(nv,3);m.f.resize(nf,3);const char*q=d.data()+h;for(int i=0;i<nv;i++)for(int c=0;c<3;c++){float x;memcpy(&x,q,4);q+=4;m.p(i,c)=x;}for(int i=0;i<nf;i++){q++;for(int c=0;c<3;c++){int x;memcpy(&x,q,4);q+=4;m.f(i,c)=x;}}return m;}
int main(int c,char**v){ int modes=std::stoi(v[2]),tests=std::stoi(v[3]),most=c>4?std::stoi(v[4]):1000;
 std::vector<std::string> fs;for(auto&e:std::filesystem::directory_iterator(v[1]))if(e.path().extension()==".ply")fs.push_back(e.path());std::sort(fs.begin(),fs.end()); if((int)fs.size()>most){std::vector<std::string> k;for(int i=0;i<most;i++)k.push_back(fs[i*fs.size()/most]);fs=k;}
 set_thread_count(1);std::vector<Points> P;Faces F;for(auto&f:fs){M m=read(f);P.push_back(m.p);F=m.f;}
 Topology T(F,P[0].rows());int N=P.size();
 double sum[5][3]={};int n=0; double anchors[]={0.05,0.05,0.5};
 for(int q=0;q<tests;q++){int out=(q*N)/tests;Collection C{T,{}, {}, {}};for(int i=0;i<N;i++)if(i!=out){C.points.push_back(P[i]);C.names.push_back(std::to_string(i));}
  ShapeModel m=fit_model(C,{.modes=modes});Collection one{T,{"x"},{P[out]},{}};auto pr=project(m,one);int K=m.mode_count();
  VectorXd w=VectorXd::Constant(N-1,1.0/(N-1));for(int k=0;k<K;k++)w+=pr.scores(0,k)/(m.variances[k]*(N-2))*m.scores.col(k);
  PatchTurns pt(T,C.points[0]);Eigen::MatrixXd TT=pt.of(C.points);VectorXd turns=TT.transpose()*w;
  // positional companion: aligned to the first, blended
  ShapePoint g=std::get<ShapePoint>(model_point(m,pr.scores.row(0).transpose(),pr.sizes[0]));
  DihedralEmbedder e(T,{C.points[0]});
  auto err=[&](const Points&x,int slot){VectorXd l=edge_lengths(T,x),L=edge_lengths(T,P[out]);Points y=x*(L.sum()/l.sum());y=best_rigid_motion(y,P[out])(y);double d=std::sqrt((y-P[out]).rowwise().squaredNorm().mean());l*=L.sum()/l.sum();sum[slot][0]+=d;sum[slot][1]+=std::sqrt((l-L).squaredNorm()/L.size())/L.mean();VectorXd q2=edge_lengths(T,x);sum[slot][2]+=std::sqrt((q2-g.edge_lengths).squaredNorm()/L.size())/L.mean();};
  err(e.embed(g).points,0);
  ShapePoint h=g;h.patch_turns=turns;DihedralEmbeddingOptions o;auto r=e.embed(h,o);err(r.points,1);err(r.companion,2);
  o.anchor=0.3;err(e.embed(h,o).points,3); o.anchor=3; err(e.embed(h,o).points,4);
  n++;
 }
 const char*nm[]={"plain","turns .05","companion","turns .3","turns 3"};
 for(int s=0;s<5;s++)printf("%-10s vertex %.5f edge %.4f%%  residual to target %.4f%%\n",nm[s],sum[s][0]/n,100*sum[s][1]/n,100*sum[s][2]/n);
}
