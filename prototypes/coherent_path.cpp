#include <chrono>
#include <Eigen/Eigenvalues>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
#include <sstream>
#include <algorithm>
#include "libshape/edge_space/shape_vectors.h"
#include "libshape/edge_space/patch_turns.h"
#include "libshape/edge_space/paths.h"
#include "libshape/embedding/dihedral/dihedral_embedding.h"
#include "libshape/embedding/report.h"
#include "libshape/embedding/sequence_jumps.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/base/threads.h"
using namespace shape; using namespace shape::internal; using Eigen::VectorXd;
struct M{Points p;Faces f;};
M read(const std::string&path){std::ifstream s(path,std::ios::binary);std::stringstream b;b<<s.rdbuf();std::string d=b.str();auto h=d.find("end_header\n")+11;std::string t=d.substr(0,h);int nv=std::stoi(t.substr(t.find("element vertex ")+15)),nf=std::stoi(t.substr(t.find("element face ")+13));bool dbl=t.find("double x")!=std::string::npos;M m;m.p.resize(nv,3);m.f.resize(nf,3);const char*q=d.data()+h;for(int i=0;i<nv;i++)for(int c=0;c<3;c++){if(dbl){double x;memcpy(&x,q,8);q+=8;m.p(i,c)=x;}else{float x;memcpy(&x,q,4);q+=4;m.p(i,c)=x;}}for(int i=0;i<nf;i++){q++;for(int c=0;c<3;c++){int x;memcpy(&x,q,4);q+=4;m.f(i,c)=x;}}return m;}
struct Step{double d,b;};
static double med(std::vector<double> v){std::sort(v.begin(),v.end());size_t n=v.size();return n%2?v[n/2]:0.5*(v[n/2-1]+v[n/2]);}
double worst(const std::vector<double>&s,double least,size_t&at){double w=0;for(size_t k=0;k<s.size();k++){std::vector<double> n;for(size_t j=k>4?k-4:0;j<s.size()&&j<=k+4;j++)if(j!=k)n.push_back(s[j]);double r=s[k]/std::max(med(n),least);if(r>w){w=r;at=k;}}return w;}
int main(int c,char**v){
  std::string mode=v[1]; M A=read(v[2]),B=read(v[3]); int frames=std::stoi(v[4]); 
  int K=c>5?std::stoi(v[5]):16; double hold=c>6?std::stod(v[6]):0.0; int iters=c>7?std::stoi(v[7]):24;
  double anchor=0.05; auto env=[](const char*n,double d){return getenv(n)?atof(getenv(n)):d;}; double zs=env("ZS",0.3),weak=env("WEAK",0),fall=env("FALL",0.7);int rings=env("RINGS",3),face_steps=env("FS",0);double zone=0;std::vector<double> zones;
  set_thread_count(1);
  Collection col{Topology(A.f,A.p.rows()),{"a","b"},{A.p,B.p},{}};
  const Topology&T=col.topology; auto vec=shape_vectors(col,Scale::None);
  DihedralEmbedder emb(T,col.points); PatchTurns turns(T,A.p);
  auto target=[&](double t){return blend(vec,Eigen::Vector2d(1-t,t));};
  auto t0=std::chrono::steady_clock::now();
  auto secs=[&]{return std::chrono::duration<double>(std::chrono::steady_clock::now()-t0).count();};
  std::vector<Points> X; std::vector<VectorXd> TH; std::vector<double> rms; double wm=0;
  DihedralEmbeddingOptions fine; fine.anchor=anchor;
  std::vector<VectorXd> Dl,Dt,Dp; double keytime=0;
  if(mode=="keys"||mode=="visc"){
    std::string cf=getenv("CACHE")?getenv("CACHE"):"";std::ifstream ci(cf,std::ios::binary);std::ofstream co;bool have=!cf.empty()&&ci.good();if(!cf.empty()&&!have)co.open(cf,std::ios::binary);
    for(int k=0;k<=K;k++){double t=double(k)/K;auto g=target(t);Points x(T.vertex_count(),3);if(have)ci.read((char*)x.data(),x.size()*8);else{x=emb.embed(g,fine).points;if(co.is_open())co.write((char*)x.data(),x.size()*8);}
      Dl.push_back(edge_lengths(T,x)-g.edge_lengths);Dt.push_back((dihedral_angles(T,x)-g.dihedral_angles).unaryExpr(&wrapped_angle));
      Dp.push_back(turns.of(x)-g.patch_turns); if(k==0||k==K){Dl.back().setZero();Dt.back().setZero();Dp.back().setZero();}}
    if(getenv("UNWRAP"))for(int k=1;k<=K;k++)for(int e=0;e<T.edge_count();e++)Dt[k][e]=Dt[k-1][e]+wrapped_angle(Dt[k][e]-Dt[k-1][e]);
    if(getenv("VERB"))for(int k=1;k<=K;k++){VectorXd q=(Dt[k]-Dt[k-1]);int n1=0,n2=0,n3=0,n5=0;for(double y:q){n1+=std::abs(y)>0.3;n2+=std::abs(y)>1;n3+=std::abs(y)>2;n5+=std::abs(y)>3.2;}printf("  key %d: >.3 %d >1 %d >2 %d >3.2 %d turns %.3f\n",k,n1,n2,n3,n5,(Dp[k]-Dp[k-1]).cwiseAbs().maxCoeff());}
    for(int k=1;k<=K;k++)for(int p=0;p<Dp[k].size()/3;p++){Eigen::Vector3d cur=Dp[k].segment<3>(3*p)+target(double(k)/K).patch_turns.segment<3>(3*p);double n=cur.norm();if(n<1e-9)continue;Eigen::Vector3d ref=target(double(k)/K).patch_turns.segment<3>(3*p)+Dp[k-1].segment<3>(3*p);Eigen::Vector3d best=cur;for(int m=-1;m<=1;m++){Eigen::Vector3d q=cur*(1+m*2*M_PI/n);if((q-ref).norm()<(best-ref).norm())best=q;}Dp[k].segment<3>(3*p)+=best-cur;}

    if(getenv("VERB"))printf("last turn diff %.3f\n",(Dp[K]-Dp[K-1]).cwiseAbs().maxCoeff());
    keytime=secs();
  }
  VectorXd shift=VectorXd::Zero(T.edge_count());double tau=env("TAU",0);
  if(tau>0&&!Dt.empty()){std::vector<int> ze;Eigen::Matrix3d cov=Eigen::Matrix3d::Zero();Eigen::Vector3d mean=Eigen::Vector3d::Zero();auto mid=[&](int e){return Eigen::Vector3d(0.5*(B.p.row(T.edges()(e,0))+B.p.row(T.edges()(e,1))).transpose());};
    for(int e=0;e<T.edge_count();e++){double m=0;for(int k=1;k<=K;k++)m=std::max(m,std::abs(Dt[k][e]-Dt[k-1][e]));if(m>0.3){ze.push_back(e);mean+=mid(e);}}
    mean/=ze.size();for(int e:ze){auto d=Eigen::Vector3d(mid(e)-mean);cov+=d*d.transpose();}Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> es(cov);int axis=int(env("AXIS",2));Eigen::Vector3d a=es.eigenvectors().col(axis);double sd=std::sqrt(es.eigenvalues()[axis]/ze.size());
    std::vector<char> inz(T.vertex_count(),0);for(int e:ze)inz[T.edges()(e,0)]=inz[T.edges()(e,1)]=1;for(int r=0;r<2;r++){auto n=inz;for(int e=0;e<T.edge_count();e++)if(inz[T.edges()(e,0)]||inz[T.edges()(e,1)])n[T.edges()(e,0)]=n[T.edges()(e,1)]=1;inz=n;}
    for(int e=0;e<T.edge_count();e++)if(inz[T.edges()(e,0)]&&inz[T.edges()(e,1)])shift[e]=tau*std::clamp((mid(e)-mean).dot(a)/(1.7*sd),-1.0,1.0);printf("zone edges %zu\n",ze.size());}
  for(int i=0;i<frames;i++){double t=double(i)/(frames-1);auto g=target(t);Points x;
    if(mode=="left"||mode=="right"||mode=="bridge"||mode=="visc"){}
    else if(mode=="indep"){auto r0=emb.embed(g,fine);x=r0.points;zone=r0.energy*1e3;}
    else{auto w=b_spline_weights(K+1,t);auto h=g;VectorXd l=VectorXd::Zero(T.edge_count()),th=l,sp=l;
      for(int k=0;k<=K;k++)if(w[k]!=0){l+=w[k]*Dl[k];th+=w[k]*Dt[k];h.patch_turns+=w[k]*Dp[k];}
      if(tau>0)for(int e=0;e<T.edge_count();e++)if(shift[e]!=0){double fade=std::min(1.0,std::min(t,1-t)/0.1);auto we=b_spline_weights(K+1,std::clamp(t+fade*shift[e],0.0,1.0));l[e]=th[e]=0;for(int k=0;k<=K;k++)if(we[k]!=0){l[e]+=we[k]*Dl[k][e];th[e]+=we[k]*Dt[k][e];}}
      for(int k=0;k<=K;k++)if(w[k]!=0)sp.array()+=w[k]*(Dt[k]-th).array().square();
      h.edge_lengths+=l;h.dihedral_angles+=th;TH.push_back(h.dihedral_angles);
      // zone: per vertex, largest spread of its edges, two rings of means
      VectorXd z=VectorXd::Zero(T.vertex_count());
      for(int e=0;e<T.edge_count();e++)for(int s2:{0,1}){int v2=T.edges()(e,s2);z[v2]=std::max(z[v2],std::min(1.0,sp[e]/(zs*zs)));}
      for(int r=0;r<rings;r++){VectorXd n=z;for(int e=0;e<T.edge_count();e++){int p=T.edges()(e,0),q=T.edges()(e,1);n[p]=std::max(n[p],fall*z[q]);n[q]=std::max(n[q],fall*z[p]);}z=n;}
      zone=z.sum();
      {ShapePoint q=h;double ml=env("ML",1),mt=env("MT",1);q.edge_lengths=g.edge_lengths+ml*l;q.dihedral_angles=g.dihedral_angles+mt*th;x=emb.follow(h,q,iters).points;}}
    zones.push_back(zone);if(x.rows()==0)continue;auto r=measure_embedding(T,x,g);rms.push_back(r.edge_rms);wm=std::max(wm,r.edge_max);
    if(!X.empty())x=best_rigid_motion(x,X.back())(x);X.push_back(x);}
  struct D3{VectorXd l,t,p;};
  auto nearest_turns=[&](VectorXd v,const VectorXd&ref){for(int p=0;p<v.size()/3;p++){Eigen::Vector3d cur=v.segment<3>(3*p);double n=cur.norm();if(n<1e-9)continue;Eigen::Vector3d best=cur;for(int m=-2;m<=2;m++){Eigen::Vector3d q=cur*(1+m*2*M_PI/n);if((q-ref.segment<3>(3*p)).norm()<(best-ref.segment<3>(3*p)).norm())best=q;}v.segment<3>(3*p)=best;}return v;};
  auto measure=[&](const Points&x,const ShapePoint&g,const D3&ref){D3 d;d.l=edge_lengths(T,x)-g.edge_lengths;d.t=ref.t+(dihedral_angles(T,x)-g.dihedral_angles-ref.t).unaryExpr(&wrapped_angle);d.p=nearest_turns(turns.of(x),g.patch_turns+ref.p)-g.patch_turns;return d;};
  auto plus=[&](ShapePoint g,const D3&d){g.edge_lengths+=d.l;g.dihedral_angles+=d.t;g.patch_turns+=d.p;return g;};
  auto zero=[&]{return D3{VectorXd::Zero(T.edge_count()),VectorXd::Zero(T.edge_count()),VectorXd::Zero(turns.size())};};
  auto chain=[&](bool left,int n){std::vector<Points> C(frames);std::vector<D3> DD(frames);int N=frames-1;D3 d=zero();for(int j=0;j<=N;j++){int i=left?j:N-j;double t=double(i)/N;auto g=target(t);C[i]=j==0?(left?A.p:B.p):emb.follow(plus(g,d),g,n).points;d=j==0?zero():measure(C[i],g,d);DD[i]=d;}return std::pair(C,DD);};
  auto push=[&](Points x,double t){auto g=target(t);auto r=measure_embedding(T,x,g);rms.push_back(r.edge_rms);wm=std::max(wm,r.edge_max);if(!X.empty())x=best_rigid_motion(x,X.back())(x);X.push_back(x);};
  if(mode=="left"||mode=="right"){X.clear();rms.clear();zones.clear();wm=0;auto [C,DD]=chain(mode=="left",iters);if(mode=="right")std::reverse(C.begin(),C.end());for(int i=0;i<frames;i++){double t=double(i)/(frames-1);if(mode=="right")t=1-t;push(C[i],t);zones.push_back(0);}}
  if(mode=="bridge"){int N=frames-1;auto [L,DL]=chain(true,iters);auto [R,DR]=chain(false,iters);
    double C=env("C",0.35),W=env("W",0.12);int BI=env("BI",6);X.clear();rms.clear();zones.clear();wm=0;D3 d=zero();
    for(int i=0;i<frames;i++){double t=double(i)/N;auto g=target(t);double u=std::clamp((t-C+W)/(2*W),0.0,1.0),sg=u*u*(3-2*u);Points x;
      if(sg==0){x=L[i];d=DL[i];}else{D3 bias;D3 r=DR[i];r.t=DL[i].t+(r.t-DL[i].t).unaryExpr(&wrapped_angle);bias.l=(1-sg)*DL[i].l+sg*r.l;bias.t=(1-sg)*DL[i].t+sg*r.t;bias.p=d.p;
        x=emb.follow(plus(g,d),plus(g,bias),BI,0.005*env("MU",1)).points;d=measure(x,g,d);}
      push(x,t);zones.push_back(100*(best_rigid_motion(x,R[i])(x)-R[i]).rowwise().norm().maxCoeff()/bounding_box_diagonal(R[i]));}
  }
  if(mode=="visc"){int G=env("G",8);int n=K*G;int BI=iters;X.clear();rms.clear();zones.clear();wm=0;TH.clear();
    auto smooth=[&](double t){auto w=b_spline_weights(K+1,t);D3 d=zero();for(int k=0;k<=K;k++)if(w[k]!=0){d.l+=w[k]*Dl[k];d.t+=w[k]*Dt[k];d.p+=w[k]*Dp[k];}return d;};
    std::vector<D3> S(n+1);S[0]=zero();S[n]=zero();S[n].t=Dt[K];S[n].p=Dp[K];
    for(int j=1;j<n;j++){double t=double(j)/n;auto g=target(t);D3 b=smooth(t),d=S[j-1];d.p=b.p;Points x=emb.follow(plus(g,d),plus(g,b),BI).points;S[j]=measure(x,g,S[j-1]);S[j].p=b.p;}
    printf("chain %.2fs\n",secs());
    // end: fade what is left of the lag
    for(int i=0;i<frames;i++){double t=double(i)/(frames-1);auto g=target(t);double u=t*n;int j=std::min(int(u),n-1);double f=u-j;D3 d;d.l=(1-f)*S[j].l+f*S[j+1].l;d.t=(1-f)*S[j].t+f*S[j+1].t;d.p=(1-f)*S[j].p+f*S[j+1].p;auto h=plus(g,d);Points x=i==0?A.p:i==frames-1?B.p:emb.follow(h,h,int(env("FI",6))).points;push(x,t);D3 b=smooth(t);zones.push_back((b.t-d.t).unaryExpr(&wrapped_angle).cwiseAbs().maxCoeff());}
  }
  double total=secs();
  std::vector<SequenceStep> st;std::vector<double> d,b;for(size_t i=0;i+1<X.size();i++){st.push_back(measure_step(T,X[i],X[i+1]));d.push_back(st.back().displacement);b.push_back(st.back().bending);}
  size_t at=0,at2=0;double wd=worst(d,2e-4,at),wb=worst(b,4e-4,at2);
  printf("%s jumps %zu  disp ratio %.2f @%zu (%.4f) bend ratio %.2f @%zu (%.4f)  rms max %.4f%% mean %.4f%% worst edge %.2f%%  total %.2fs keys %.2fs\n",mode.c_str(),find_jumps(st).size(),wd,at,d[at],wb,at2,b[at2],100**std::max_element(rms.begin(),rms.end()),100*VectorXd::Map(rms.data(),rms.size()).mean(),100*wm,total,keytime);
  for(auto&j:find_jumps(st))printf("  jump %zu %.1f\n",j.from,j.ratio);
  if(getenv("TOP")){int i=atoi(getenv("TOP"));VectorXd a=dihedral_angles(T,X[i]),b2=dihedral_angles(T,X[i+1]);VectorXd ch=(b2-a).unaryExpr(&wrapped_angle);VectorXd ar=VectorXd::Zero(T.edge_count());double tot=0;for(int f=0;f<T.face_count();f++){Eigen::Vector3d p=X[i].row(T.faces()(f,0)),q=X[i].row(T.faces()(f,1)),r=X[i].row(T.faces()(f,2));double A2=(q-p).cross(r-p).norm();for(int k=0;k<3;k++)ar[T.face_edges()(f,k)]+=A2;tot+=3*A2;}
    std::vector<int> o(T.edge_count());for(size_t k=0;k<o.size();k++)o[k]=k;std::sort(o.begin(),o.end(),[&](int p,int q){return ar[p]*ch[p]*ch[p]>ar[q]*ch[q]*ch[q];});for(int k=0;k<16;k++){int e=o[k];printf("  e%d v%d-%d share %.2e dtheta %.2f (%.2f -> %.2f) target %.2f -> %.2f\n",e,T.edges()(e,0),T.edges()(e,1),ar[e]/tot,ch[e],a[e],b2[e],TH[i][e],TH[i+1][e]);}}
  if(getenv("STEPS"))for(size_t i=0;i<d.size();i++)printf("%zu %.5f %.5f %.4f %.2f\n",i,d[i],b[i],100*rms[i],zones[i]);
  if(getenv("DUMP")){std::ofstream o(getenv("DUMP"),std::ios::binary);for(auto&x:X)o.write((char*)x.data(),x.size()*8);}
}
